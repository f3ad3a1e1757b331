#include "tasks/shell_game/touch_rule.h"

#include <algorithm>
#include <cmath>

#include "core/math/real_functions.h"
#include "tasks/common/tool_servo.h"
#include "tasks/common/touch_latch.h"
#include "tasks/common/tour.h"

namespace engram::tasks {
namespace {

constexpr double MUG_DISPLACEMENT_PENALTY_COEF = 0.1;
constexpr double MUG_DISPLACEMENT_SUCCESS_THRESH = 0.05;  // m
constexpr double kSuccessReward = 3;

// The oracle's way: over the mug, then down until it is touched.
constexpr double kTravelGap = 0.063;    // m more while on the way
constexpr double kDescent = 0.04;       // m at most at a time: fast tools overshoot
constexpr double kCloseEnough = 0.003;  // m
// The farthest slots of all are out of a vertical tool's reach.
constexpr Lean kLean{.reach = 0.78, .per_metre = 5.0, .most = 0.4};

// Who has no memory goes from mug to mug.
constexpr double kBegun = 0.012;  // m above a touch: a tool below that has begun
constexpr double kFunnel = 0.02;  // m: the way down to the first one
constexpr double kFunnelSlope = 0.5;
constexpr double kLower = 0.002;      // m below the oracle
constexpr double kRestRadius = 0.03;  // m at most, around a touch, where the tool comes to rest
constexpr double kMargin = 0.005;     // m
constexpr double kLeaving = 0.2;      // rad/s, of the base: the tool goes on from the first one

Eigen::Quaterniond tool_over(const Eigen::Vector3d& goal) {
  const bool far = (goal - Eigen::Vector3d(kRobotBaseX, 0, goal.z())).norm() > kLean.reach;
  return far ? lean_outwards(kToolDown, goal, kLean) : kToolDown;
}

bool is_fair(double displacement) { return displacement <= MUG_DISPLACEMENT_SUCCESS_THRESH; }

template <class Row>
void list_terms(Row& row, bool shoving, const TouchRule::RewardInputs& in,
                const TouchRule::RewardTerms& terms) {
  row.term("reaching_reward", "", terms.reaching);
  row.term("static_reward", "", terms.stillness);
  row.term("tcp_to_obj_dist", "m", in.distance);
  if (shoving) {
    row.term("mug_max_displacement", "m", in.displacement);
    row.term("mug_shift_penalty", "", terms.shift);
    row.term("is_mug_displacement_ok", "", is_fair(in.displacement));
  }
  row.term(shoving ? "info[\"is_obj_placed\"]" : "is_obj_placed", "", in.placed);
}

}  // namespace

void TouchRule::declare(ConstantBinder& constants) {
  constants.fixed({{"MUG_DISPLACEMENT_PENALTY_COEF", MUG_DISPLACEMENT_PENALTY_COEF},
                   {"MUG_DISPLACEMENT_SUCCESS_THRESH", MUG_DISPLACEMENT_SUCCESS_THRESH}});
}

void TouchRule::describe(TaskInfo& info) const {
  info.reward_terms = reward_terms_of([&](auto& row) { list_terms(row, shoving_, {}, {}); });
  info.answer =
      "the first cup within GOAL_THRESH of which the robot rests in the manipulation phase, the "
      "nearest one if there are several; its slot";
}

void TouchRule::bind(const Bindings& bindings) {
  displacement_ = bindings.memory->add<double>("mug_max_displacement", 1, "m");
  if (!shoving_) return;
  mug_max_displacement_ = bindings.outputs->add<float>(
      "mug_max_displacement", 1, "m", "farthest that a mug was shoved since it appeared");
  is_mug_displacement_ok_ = bindings.outputs->add<std::uint8_t>("is_mug_displacement_ok");
}

// --- success ---

ShellGame::Verdict TouchRule::judge(const ShellGame& game, int env, const Eigen::Vector3d& goal,
                                    double displacement) const {
  const Eigen::Vector3d offset = goal - game.tcp_pos(env);
  displacement_[env] = displacement;
  if (shoving_) {
    mug_max_displacement_[env] = static_cast<float>(displacement);
    is_mug_displacement_ok_[env] = is_fair(displacement) ? 1 : 0;
  }
  return {.obj_to_goal = offset,
          .placed = offset.norm() <= goal_thresh_,
          .still = robot_is_static(game.state(), env),
          .fair = is_fair(displacement)};
}

int TouchRule::touched_mug(const ShellGame& game, int env) const {
  const State& state = game.state();
  if (!game.is_manipulation(env) || !robot_is_static(state, env)) return -1;
  return touched_object(state.prop_pos_of(env, 0), kCups, state.tcp_pos.row(env), goal_thresh_);
}

// --- reward ---

TouchRule::RewardTerms TouchRule::reward(const RewardInputs& in) {
  RewardTerms terms;
  terms.reaching = 1 - real::tanh(5 * in.distance);
  terms.stillness = 1 - real::tanh(5 * in.arm_speed);
  terms.shift = MUG_DISPLACEMENT_PENALTY_COEF * real::tanh(10 * in.displacement);
  if (in.success) {
    terms.reward = kSuccessReward;
  } else if (in.manipulation) {
    const double placed = in.placed ? terms.stillness + (in.robot_static ? 1 : 0) : 0;
    terms.reward = terms.reaching + placed - terms.shift;
  }
  return terms;
}

void TouchRule::dense_reward(const ShellGame& game, Range envs, FloatRows out) const {
  for (int env = envs.begin; env < envs.end; ++env) {
    RewardInputs in;
    in.distance = game.obj_to_goal(env).norm();
    in.displacement = displacement_[env];
    game.fill_in(env, in);
    const RewardTerms terms = reward(in);
    game.reward_dict().note(env, [&](auto& row) { list_terms(row, shoving_, in, terms); });
    *out.row(env) = static_cast<float>(terms.reward);
  }
}

// --- oracle ---

void TouchRule::act(const ShellGame& game, Range envs, Script script, FloatRows actions) const {
  // Demonstrations of the Long ids keep the fingers open all the time.
  const double gripper = game.info().frozen_cue ? kGripperClosed : kGripperOpen;
  for (int env = envs.begin; env < envs.end; ++env) {
    float* action = actions.row(env);
    if (!game.is_manipulation(env)) {
      hold_tool(kGripperOpen, action);
    } else if (script == Script::kSweep && !game.is_told()) {
      sweep(game, env, gripper, action);
    } else {
      touch(game, env, game.chosen_slot(env, script), gripper, action);
    }
  }
}

// Over the mug, then down until it is touched.
void TouchRule::touch(const ShellGame& game, int env, int slot, double gripper,
                      float* action) const {
  const Eigen::Vector3d goal =
      game.mugs().standing_pos(env, slot) + Eigen::Vector3d(0, 0, touch_gap_);
  const Eigen::Vector3d tcp = game.tcp_pos(env);
  if ((tcp - goal).norm() < kCloseEnough) {
    hold_tool(gripper, action);
    return;
  }
  Eigen::Vector3d way = approach_from_above(game.state(), env, goal, kTravelGap);
  way.z() = std::max(way.z(), tcp.z() - kDescent);
  servo_tool(game.state(), env, way, tool_over(goal), gripper, action);
}

// Rests over one mug after the other. Nothing tells the last step of a shuffle from those in
// between, so that where the robot is not frozen it waits for as long as a shuffle may take.
void TouchRule::sweep(const ShellGame& game, int env, double gripper, float* action) const {
  const State& state = game.state();
  if (!game.info().frozen_cue && state.elapsed[env] < latest_start_) {
    hold_tool(gripper, action);
    return;
  }
  const double gap = touch_gap_ - kLower;
  const auto over = [&](int slot) -> Eigen::Vector3d {
    return game.mugs().standing_pos(env, slot) + Eigen::Vector3d(0, 0, gap);
  };
  const double start_height = over(0).z() + kBegun;
  const double reach =
      std::min(kRestRadius, std::sqrt(goal_thresh_ * goal_thresh_ - gap * gap) - kMargin);
  Tour::Move move{approach_by_funnel(state, env, over(0), kFunnel, kFunnelSlope)};
  if (game.tcp_pos(env).z() < start_height) {
    Tour tour;
    const bool leaves_first = state.qvel.row(env)[0] > kLeaving;
    for (int slot = leaves_first ? 1 : 0; slot < kCups; ++slot) tour.add(over(slot));
    move = tour.next(state, env, {.start_height = start_height, .reach = reach});
  }
  if (move.rest) {
    hold_tool(gripper, action);
  } else {
    servo_tool(state, env, move.goal, tool_over(move.goal), gripper, action);
  }
}

}  // namespace engram::tasks
