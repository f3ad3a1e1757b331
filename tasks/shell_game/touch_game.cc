#include "tasks/shell_game/touch_game.h"

#include <algorithm>
#include <cmath>

#include "tasks/parts/tool_servo.h"

namespace engram::tasks {
namespace {

constexpr double MUG_DISPLACEMENT_PENALTY_COEF = 0.1;
constexpr double MUG_DISPLACEMENT_SUCCESS_THRESH = 0.05;  // m
constexpr double kSuccessReward = 3;

// The oracle's way (shell 8.2): over the mug, then down until the fingertips are a centimetre
// above its foot. Nothing is touched, so nothing can be shoved.
constexpr double kHoverGap = 0.074;     // m above the mug's origin
constexpr double kTravelGap = 0.063;    // m more while on the way
constexpr double kDescent = 0.04;       // m at most at a time: fast tools overshoot
constexpr double kCloseEnough = 0.003;  // m

std::vector<std::string> reward_terms(bool shoving) {
  if (!shoving) return {"reaching_reward", "static_reward", "tcp_to_obj_dist", "is_obj_placed"};
  return {"reaching_reward",        "static_reward",     "tcp_to_obj_dist",
          "mug_max_displacement",   "mug_shift_penalty", "is_mug_displacement_ok",
          "info[\"is_obj_placed\"]"};
}

}  // namespace

ShellTouchTerms shell_touch_reward(const ShellTouchInputs& in) {
  ShellTouchTerms terms;
  terms.reaching = 1 - std::tanh(5 * in.distance);
  terms.stillness = 1 - std::tanh(5 * in.arm_speed);
  terms.shift = MUG_DISPLACEMENT_PENALTY_COEF * std::tanh(10 * in.displacement);
  if (in.success) {
    terms.reward = kSuccessReward;
  } else if (in.manipulation) {
    const double placed = in.placed ? terms.stillness + (in.robot_static ? 1 : 0) : 0;
    terms.reward = terms.reaching + placed - terms.shift;
  }
  return terms;
}

ShellTouchGame::ShellTouchGame(const RegistryEntry& entry, const Setup& setup, bool shoving)
    : ShellGame(entry, setup), shoving_(shoving) {
  info_.reward_terms = reward_terms(shoving);
  if (!shoving) return;
  info_.constants.emplace_back("MUG_DISPLACEMENT_PENALTY_COEF", MUG_DISPLACEMENT_PENALTY_COEF);
  info_.constants.emplace_back("MUG_DISPLACEMENT_SUCCESS_THRESH", MUG_DISPLACEMENT_SUCCESS_THRESH);
}

void ShellTouchGame::bind(const Bindings& bindings) {
  ShellGame::bind(bindings);
  displacement_ = bindings.memory->add<double>("mug_max_displacement", 1, "m");
  if (!shoving_) return;
  mug_max_displacement_ = bindings.outputs->add<float>(
      "mug_max_displacement", 1, "m", "farthest that a mug was shoved since it appeared");
  is_mug_displacement_ok_ = bindings.outputs->add<std::uint8_t>("is_mug_displacement_ok");
}

void ShellTouchGame::judge(int env, const Eigen::Vector3d& goal, double displacement) const {
  const Eigen::Vector3d offset = goal - tcp_pos(env);
  const bool fair = displacement <= MUG_DISPLACEMENT_SUCCESS_THRESH;
  displacement_[env] = displacement;
  if (shoving_) {
    mug_max_displacement_[env] = static_cast<float>(displacement);
    is_mug_displacement_ok_[env] = fair ? 1 : 0;
  }
  conclude(env, {.obj_to_goal = offset,
                 .placed = offset.norm() <= setup_.GOAL_THRESH,
                 .still = robot_is_static(*engine_.state, env),
                 .fair = fair});
}

void ShellTouchGame::dense_reward(Range envs, FloatRows out) {
  for (int env = envs.begin; env < envs.end; ++env) {
    ShellTouchInputs in;
    in.distance = obj_to_goal_distance(env);
    in.arm_speed = arm_speed(env);
    in.displacement = displacement_[env];
    in.robot_static = is_robot_static_[env] != 0;
    in.placed = is_obj_placed_[env] != 0;
    in.manipulation = is_manipulation(env);
    in.success = engine_.success[env] != 0;
    const ShellTouchTerms terms = shell_touch_reward(in);
    const double placed = in.placed ? 1 : 0;
    if (shoving_) {
      const double fair = in.displacement <= MUG_DISPLACEMENT_SUCCESS_THRESH ? 1 : 0;
      reward_dict_.note<7>(env, {terms.reaching, terms.stillness, in.distance, in.displacement,
                                 terms.shift, fair, placed});
    } else {
      reward_dict_.note<4>(env, {terms.reaching, terms.stillness, in.distance, placed});
    }
    *out.row(env) = static_cast<float>(terms.reward);
  }
}

void ShellTouchGame::act(Range envs, bool blind, FloatRows actions) {
  for (int env = envs.begin; env < envs.end; ++env) {
    float* action = actions.row(env);
    const Eigen::Vector3d goal =
        mug_slot_pos(env, chosen_slot(env, blind)) + Eigen::Vector3d(0, 0, kHoverGap);
    if (!is_manipulation(env) || (tcp_pos(env) - goal).norm() < kCloseEnough) {
      hold_tool(kGripperClosed, action);
    } else {
      const State& state = *engine_.state;
      Eigen::Vector3d way = approach_from_above(state, env, goal, kTravelGap);
      way.z() = std::max(way.z(), tcp_pos(env).z() - kDescent);
      servo_tool(state, env, way, kToolDown, kGripperClosed, action);
    }
  }
}

}  // namespace engram::tasks
