#include "tasks/trace_shape/expert.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "core/math/real_functions.h"
#include "tasks/common/grasp_servo.h"
#include "tasks/common/guess_stream.h"
#include "tasks/common/poses.h"
#include "tasks/trace_shape/chance.h"

namespace engram::tasks {
namespace {

constexpr double kGraspHeight = 0.12;  // m, of the TCP between two places
constexpr double kTraceHeight = 0.06;  // m, of the TCP while it carries the cube

// The red cube may have pushed the green one (red_pushes_green) where a vertical tool cannot
// follow.
constexpr Tilt kTilt{.fold = 0.33};

// Centre of the button, pulled towards the robot as far as the press radius allows where it is hard
// to reach.
Vec2 press_point(const Vec2& center) {
  constexpr double kEasyReach = 0.75;  // m
  constexpr double kMaxPull = 0.055;   // m
  const Vec2 base(kRobotBaseX, 0);
  const Vec2 outward = center - base;
  const double reach = outward.norm();
  const double pull = std::clamp(reach - kEasyReach, 0.0, kMaxPull);
  return base + outward * ((reach - pull) / reach);
}

// A ring and the sense of rotation, +1 counter-clockwise.
struct Ring {
  double radius = 0;  // m
  int turn = 1;
};

// Ring of a step count, of those between two radii. Each ring has as many steps as it is long.
// Every other round turns in the opposite sense, so that the arm does not wind up.
Ring ring_at(int elapsed, double least, double most, double reach) {
  constexpr double kSure = 0.8;      // of the reach
  constexpr double kStride = 0.018;  // m per control step
  const double width = most - least;
  const int count = std::max(1, static_cast<int>(std::ceil(width / (2 * kSure * reach))));
  const auto radius = [&](int ring) { return least + width * (ring + 0.5) / count; };
  const auto steps = [&](int ring) {
    return static_cast<int>(2 * std::numbers::pi * radius(ring) / kStride);
  };
  int round = 0;
  for (int ring = 0; ring < count; ++ring) round += steps(ring);
  int left = elapsed % round;
  int ring = 0;
  while (left >= steps(ring)) left -= steps(ring++);
  return {radius(ring), elapsed / round % 2 == 0 ? 1 : -1};
}

// Grasps the cube, then leads it low over the table to the point that `goal` returns.
template <class Goal>
void lead_cube(const State& state, int env, int cube, Goal goal, float* action) {
  const Eigen::Vector3d pos = prop_pos(state, env, cube);
  Grip grip{.prop = cube,
            .tool = tilt_outwards(cube_grasp_orientation(state, env, cube), pos, kTilt),
            .travel_height = kGraspHeight};
  if (!grasp(state, env, grip, action)) return;
  const double in_hand = state.tcp_pos.row(env)[2] - pos.z();
  grip.travel_height = kTraceHeight;
  // Round after round does not wind up the wrist.
  grip.tool = tilt_outwards(kToolDown, pos, kTilt);
  const Vec2 at = goal(Vec2(pos.x(), pos.y()));
  carry(state, env, grip, {at.x(), at.y(), kTraceHeight - in_hand}, action);
}

}  // namespace

// --- both tasks ---

void TraceExpert::bind(ColumnStore& memory) {
  guess_element_ = memory.add<std::int32_t>("guess_element");
  guess_visited_ = memory.add<std::int32_t>("guess_visited");
  memory.limit("guess_visited", 0, demo_.contours().all_visited());
}

ChoiceForm TraceExpert::choice_form() const {
  const TraceParams& params = demo_.params();
  const bool one = params.MAX_SEQUENCE_LENGTH == 1;
  ChoiceForm form{
      .question = one ? "Which shape was traced?" : "Which shapes were traced, in which order?",
      .least = params.MIN_SEQUENCE_LENGTH,
      .most = params.MAX_SEQUENCE_LENGTH,
      .repeats = !one};
  for (int i = 0; i < demo_.candidates(); ++i) {
    form.items.push_back(std::string("a ") + kContourNames[at(params.AVAILABLE_SHAPES[i])]);
  }
  return form;
}

double TraceExpert::choice_chance() const { return choice_rate(demo_.params()); }

int TraceExpert::guessed_length(int env) const {
  if (const std::span<const int> named = choice(env); !named.empty()) {
    return static_cast<int>(named.size());
  }
  const TraceParams& params = demo_.params();
  return guess_stream(engine_, env).integer(params.MIN_SEQUENCE_LENGTH, params.MAX_SEQUENCE_LENGTH);
}

Contour TraceExpert::guessed_contour(int env, int element) const {
  if (const std::span<const int> named = choice(env); !named.empty()) {
    // One more than were shown is as the last one.
    return demo_.candidate(env, std::min(element, demo_.length(env) - 1), named[at(element)]);
  }
  const TraceParams& params = demo_.params();
  RandomStream random = guess_stream(engine_, env);
  random.integer(params.MIN_SEQUENCE_LENGTH, params.MAX_SEQUENCE_LENGTH);
  for (int earlier = 0;; ++earlier) {
    const Contour contour = demo_.sample_contour(env, random);
    if (earlier == element) return contour;
  }
}

void TraceExpert::await_demo(float* action) const {
  constexpr double kAsWideAsTheCube = 0.22;  // 20.5 mm per finger
  hold_tcp(kAsWideAsTheCube, action);
}

void TraceExpert::trace(int env, const Contour& contour, int visited, float* action) const {
  const auto goal = [&](const Vec2& at) { return lookahead_point(contour, visited, at); };
  lead_cube(state(), env, demo_.green_cube(), goal, action);
}

void TraceExpert::sweep_rings(int env, float* action) const {
  constexpr double kAhead = 0.045;         // m
  constexpr double kMaxTurn = 0.6;         // rad
  constexpr double kMaxCorrection = 0.01;  // m
  const TraceParams& params = demo_.params();
  const Vec2 center = demo_.center(env);
  const Ring ring = ring_at(state().elapsed[env], params.nearest_point(), params.farthest_corner(),
                            demo_.contours().reach());
  const auto goal = [&](const Vec2& at) -> Vec2 {
    const Vec2 offset = at - center;
    const double angle =
        real::atan2(offset.y(), offset.x()) + ring.turn * std::min(kMaxTurn, kAhead / ring.radius);
    const double inside = std::clamp(ring.radius - offset.norm(), -kMaxCorrection, kMaxCorrection);
    return center + (ring.radius + inside) * Vec2(real::cos(angle), real::sin(angle));
  };
  lead_cube(state(), env, demo_.green_cube(), goal, action);
}

// --- TraceShape ---

void TraceShapeExpert::act(Range envs, Script script, FloatRows actions) const {
  for (int env = envs.begin; env < envs.end; ++env) {
    float* action = actions.row(env);
    if (!demo_.is_acting(env)) {
      await_demo(action);
    } else if (script == Script::kSweep) {
      sweep_rings(env, action);
    } else if (script == Script::kBlind) {
      trace(env, guessed_contour(env, 0), guess_visited_[env], action);
    } else {
      trace(env, demo_.contour(env, 0), visited_[env], action);
    }
  }
}

// Round after round, for as long as the episode lasts.
void TraceShapeExpert::follow_guess(int env, const Vec2& cube) const {
  if (awaits_choice(env)) return;
  const Contour contour = guessed_contour(env, 0);
  std::int32_t& visited = guess_visited_[env];
  visited = visit(contour, cube, visited);
  if (is_closed(contour, cube, visited)) visited = 0;
}

// --- TraceShapeSeq ---

void TraceShapeSeqExpert::bind(ColumnStore& memory) {
  TraceExpert::bind(memory);
  memory.limit("guess_element", 0, demo_.params().MAX_SEQUENCE_LENGTH);
}

void TraceShapeSeqExpert::act(Range envs, Script script, FloatRows actions) const {
  for (int env = envs.begin; env < envs.end; ++env) {
    float* action = actions.row(env);
    if (!demo_.is_acting(env)) {
      await_demo(action);
    } else if (script == Script::kSweep) {
      sweep(env, action);
    } else if (script == Script::kBlind) {
      blind(env, action);
    } else if (view_.closed[env] >= demo_.length(env)) {
      submit(env, action);
    } else {
      trace(env, demo_.contour(env, view_.active[env]), view_.visited[env], action);
    }
  }
}

void TraceShapeSeqExpert::blind(int env, float* action) const {
  const int element = guess_element_[env];
  if (element >= guessed_length(env)) {
    submit(env, action);
  } else {
    trace(env, guessed_contour(env, element), guess_visited_[env], action);
  }
}

// Rings for as long as there is time, then the button.
void TraceShapeSeqExpert::sweep(int env, float* action) const {
  constexpr int kTimeToSubmit = 75;  // control steps
  if (state().elapsed[env] < view_.info.horizon - kTimeToSubmit) {
    sweep_rings(env, action);
  } else {
    submit(env, action);
  }
}

// Releases the cube, then presses the button where it is nearest to the robot.
void TraceShapeSeqExpert::submit(int env, float* action) const {
  constexpr double kClearance = 0.06;     // m, of the TCP above the cube
  constexpr double kPressHeight = 0.075;  // m, of the TCP: nearly the full travel
  constexpr double kTravelHeight = 0.16;  // m
  const int cube = demo_.green_cube();
  const Eigen::Quaterniond tool = tool_down(tcp_yaw(state(), env));
  const Grip grip{.prop = cube, .tool = tilt_outwards(tool, prop_pos(state(), env, cube))};
  if (!release(state(), env, grip, kClearance, action)) return;
  const Vec2 at = press_point(view_.button.center(env));
  const Eigen::Vector3d goal(at.x(), at.y(), kPressHeight);
  servo_tcp_limited(state(), env, transfer_waypoint(state(), env, goal, kTravelHeight),
                    tilt_outwards(tool, goal), kGripperOpen, action);
}

void TraceShapeSeqExpert::follow_guess(int env, const Vec2& cube) const {
  if (awaits_choice(env)) return;
  std::int32_t& element = guess_element_[env];
  if (element >= guessed_length(env)) return;
  const Contour contour = guessed_contour(env, element);
  guess_visited_[env] = visit(contour, cube, guess_visited_[env]);
  if (!is_closed(contour, cube, guess_visited_[env])) return;
  ++element;
  guess_visited_[env] = 0;
}

}  // namespace engram::tasks
