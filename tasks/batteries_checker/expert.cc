#include "tasks/batteries_checker/expert.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/observe/object_words.h"
#include "tasks/common/grasp_servo.h"
#include "tasks/common/guess_stream.h"
#include "tasks/common/poses.h"
#include "tasks/common/press_servo.h"

namespace engram::tasks {
namespace {

// The fingers do not fit into the socket's hole: a battery is held so that it reaches the floor
// while they are above the rim.
constexpr double kGripHeight = 0.0015;   // m above the battery's centre
constexpr double kTableHeight = 0.05;    // m, of the TCP: where the tool is slowest
constexpr double kTravelHeight = 0.13;   // m: a battery in the hand passes over all others
constexpr double kAboveSocket = 0.0015;  // m above the floor, where a battery is let go
constexpr double kAboveTable = 0.0010;   // m
constexpr double kClearance = 0.045;     // m: of the tool above the centre of one that was released
constexpr double kOpening = 0.4;         // gripper command: 25 mm per finger
constexpr Tilt kTilt = {.reach = 0.765, .per_metre = 2.5, .most = 0.1};

// The fingers close along a diagonal of the tray, on which the neighbours are furthest away.
Eigen::Quaterniond along_diagonal() { return tool_down(std::numbers::pi / 4); }

// Tolerance of a battery's place: half of what is required, where that is little.
Tolerance within(double required) {
  return {.sideways = std::min(0.003, required / 2), .height = 0.0025};
}

Grip grip_of(int prop, const Eigen::Vector3d& goal) {
  return {.prop = prop,
          .tool = tilt_outwards(along_diagonal(), goal, kTilt),
          .height = kGripHeight,
          .opening = kOpening,
          .travel_height = kTravelHeight};
}

// Brings the tool into the middle of a battery that it is about to close on: one that is held by
// its side slips. True, and nothing is written, if there is nothing to correct.
bool is_centred(const State& state, int env, const Grip& grip, const Eigen::Vector3d& battery,
                float* action) {
  constexpr double kAround = 0.02;          // m sideways: the tool has come for this battery
  constexpr double kLow = 0.015;            // m
  constexpr double kBeforeClosing = 0.002;  // m
  constexpr double kWhileClosing = 0.005;   // m
  constexpr double kOpen = 0.02;            // m per finger
  const Eigen::Vector3d tcp = tcp_pos(state, env);
  const Eigen::Vector3d goal = battery + Eigen::Vector3d(0, 0, grip.height);
  const double distance = (goal - tcp).head<2>().norm();
  const double* fingers = state.qpos.row(env) + kArmJoints;
  const bool open = std::min(fingers[0], fingers[1]) > kOpen;
  const bool around = distance < kAround && std::abs(goal.z() - tcp.z()) < kLow;
  if (!around || distance < (open ? kBeforeClosing : kWhileClosing)) return true;
  if (is_grasping(state, env, grip.prop)) return true;  // perhaps in the air
  const Eigen::Vector3d next = open ? goal : Eigen::Vector3d(tcp.x(), tcp.y(), goal.z());
  servo_tcp(state, env, next, grip.tool, grip.opening, action);
  return false;
}

}  // namespace

void BatteryExpert::act(Range envs, Script script, FloatRows actions) const {
  for (int env = envs.begin; env < envs.end; ++env) {
    if (script == Script::kSweep) {
      sweep(env, actions.row(env));
      continue;
    }
    const CheckState state = view_.check.load(env);
    const int battery =
        script == Script::kBlind ? guess(env) : lowest(~state.checked & all_batteries());
    play_round(env, state.stage, {.battery = battery, .active = state.active}, actions.row(env));
  }
}

void BatteryExpert::play_round(int env, int stage, const Plan& plan, float* action) const {
  if (view_.params.easy && view_.check.insert_event[env] != 0) {
    hold_tcp(kOpening, action);  // a battery counts before the fingers are clear of it
  } else if (stage == STAGE_INSERT && plan.battery >= 0) {
    insert(env, plan.battery, action);
  } else if (stage == STAGE_RETURN && plan.active >= 0) {
    if (put_back(env, plan.active, action)) {
      press(env, plan.keep_down, action);
    }
  } else if (clear_tool(env, action)) {
    press(env, plan.keep_down, action);
  }
  limit_speed_near(*view_.engine.state, env, kTableHeight, action);
}

void BatteryExpert::insert(int env, int battery, float* action) const {
  const State& state = *view_.engine.state;
  const int prop = view_.rack.prop(battery);
  Eigen::Vector3d place = view_.rack.socket(env);
  place.z() = BatteryRack::kSocketRest + kAboveSocket;
  const bool held = is_held(state, env, prop);
  const Grip grip = grip_of(prop, held ? place : view_.rack.pos(env, battery));
  if (!held && !is_centred(state, env, grip, view_.rack.pos(env, battery), action)) return;
  const Tolerance tolerance = within(view_.rack.params().SOCKET_INSERT_XY_TOL);
  if (pick_and_place(state, env, grip, place, action, tolerance)) hold_tcp(kOpening, action);
}

bool BatteryExpert::put_back(int env, int battery, float* action) const {
  const State& state = *view_.engine.state;
  const int prop = view_.rack.prop(battery);
  const Eigen::Vector3d place = view_.rack.slot(env, battery) + Eigen::Vector3d(0, 0, kAboveTable);
  const bool held = is_held(state, env, prop);
  const Grip grip = grip_of(prop, held ? place : view_.rack.pos(env, battery));
  if (is_at(state, env, prop, place, within(view_.rack.params().SLOT_RETURN_XY_TOL))) {
    return release(state, env, grip, kClearance, action);
  }
  if (!held && !is_centred(state, env, grip, view_.rack.pos(env, battery), action)) return false;
  if (grasp(state, env, grip, action)) carry(state, env, grip, place, action);
  return false;
}

// Releases the battery between the fingers, if there is one; one that is held goes back to its
// slot.
bool BatteryExpert::clear_tool(int env, float* action) const {
  constexpr double kBetweenFingers = 0.02;  // m
  const State& state = *view_.engine.state;
  const Eigen::Vector3d tcp = tcp_pos(state, env);
  for (int battery = 0; battery < view_.rack.batteries(); ++battery) {
    const Eigen::Vector3d offset = view_.rack.pos(env, battery) - tcp;
    if (offset.head<2>().norm() > kBetweenFingers) continue;
    if (is_held(state, env, view_.rack.prop(battery))) {
      return put_back(env, battery, action);
    }
    const Grip grip = grip_of(view_.rack.prop(battery), tcp);
    if (!release(state, env, grip, kClearance, action)) return false;
  }
  return true;
}

// Presses on the part of the pad that is nearest to the tray.
void BatteryExpert::press(int env, bool keep_down, float* action) const {
  const State& state = *view_.engine.state;
  constexpr double kTowardsTray = 0.045;   // m
  constexpr double kInside = 0.029;        // m from the pad's edge
  constexpr double kReleaseHeight = 0.10;  // m
  constexpr double kClear = 0.012;         // m above where the button is released, or pressed
  constexpr double kOverPad = 0.02;        // m
  const PressButtonParams& pad = view_.button.params();
  const Eigen::Vector3d tcp = tcp_pos(state, env);
  const Vec2 center = view_.button.center(env);
  const double size = std::min(pad.BUTTON_PRESS_XY_RADIUS, pad.shape.BUTTON_BASE_HALF_SIZE[0]);
  const double aside = std::clamp(size - kInside, 0.0, kTowardsTray);
  Eigen::Vector3d goal(center.x(), center.y() - aside,
                       std::max(kReleaseHeight, pad.release_height() + kClear));
  if (keep_down || view_.button.ready(env))
    goal = {goal.x(), goal.y(), pressing_height(view_.button)};
  const bool over = (goal - tcp).head<2>().norm() < kOverPad;
  const double travel = std::max(kTravelHeight, pad.zone_height() + kClear);
  if (!over) goal = transfer_waypoint(state, env, goal, travel);
  servo_tcp(state, env, goal, along_diagonal(), kGripperClosed, action);
}

// Battery that an agent without memory takes: it does not know which ones it has tested, and takes
// any. The one in the socket belongs into the hole that it has left among the others. The agent
// stops after as many rounds as there are batteries.
int BatteryExpert::guess(int env) const {
  int battery = -1;
  if (view_.check.rounds[env] >= view_.params.ACTIVE_BATTERY_COUNT) return battery;
  if (is_asked(env)) {
    const std::span<const int> chosen = choice(env, view_.check.rounds[env]);
    return chosen.empty() ? battery : chosen.front();
  }
  RandomStream random = guess_stream(view_.engine, env);
  for (int round = 0; round <= view_.check.rounds[env]; ++round) {
    battery = random.integer(0, view_.params.ACTIVE_BATTERY_COUNT - 1);
  }
  return battery;
}

ChoiceForm BatteryExpert::choice_form() const {
  return {.question = "Which battery is to be tested next?",
          .questions = view_.params.ACTIVE_BATTERY_COUNT};
}

// Batteries look alike: their places tell them apart.
std::vector<std::string> BatteryExpert::choice_items(int env) const {
  std::vector<std::string> items;
  for (int battery = 0; battery < view_.rack.batteries(); ++battery) {
    const Eigen::Vector3d slot = view_.rack.slot(env, battery);
    items.push_back("the battery at x " + in_metres(slot.x()) + ", y " + in_metres(slot.y()));
  }
  return items;
}

bool BatteryExpert::is_choice_due(int env) const {
  const int rounds = view_.check.rounds[env];
  return is_asked(env) && choices_made(env) <= rounds && rounds < view_.params.ACTIVE_BATTERY_COUNT;
}

// Without memory: a clock replaces it. Every battery has its time, in the order of the slots.
void BatteryExpert::sweep(int env, float* action) const {
  constexpr double kInsertingShare = 0.5;  // of the time that a battery has
  constexpr double kOverSocket = 0.05;     // m
  const State& state = *view_.engine.state;
  const int round = std::max(1, view_.info.horizon / view_.params.ACTIVE_BATTERY_COUNT);
  const int elapsed = state.elapsed[env];
  const int battery = std::min(elapsed / round, view_.params.ACTIVE_BATTERY_COUNT - 1);
  const bool inserting = elapsed - battery * round < kInsertingShare * round;
  const Eigen::Vector3d away = view_.rack.socket(env) - tcp_pos(state, env);
  const bool home = contains(view_.rack.home(env), battery);
  if (inserting && view_.params.easy && home && away.head<2>().norm() < kOverSocket) {
    hold_tcp(kOpening, action);  // it has come back by itself
    return;
  }
  const int stage = inserting ? STAGE_INSERT : STAGE_RETURN;
  play_round(env, stage, {.battery = battery, .active = battery, .keep_down = true}, action);
}

}  // namespace engram::tasks
