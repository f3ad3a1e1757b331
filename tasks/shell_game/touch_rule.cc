#include "tasks/shell_game/touch_rule.h"

#include "core/math/real_functions.h"
#include "tasks/common/touch_latch.h"

namespace engram::tasks {
namespace {

constexpr double MUG_DISPLACEMENT_PENALTY_COEF = 0.1;
constexpr double MUG_DISPLACEMENT_SUCCESS_THRESH = 0.05;  // m
constexpr double kTouchReward = 3;

}  // namespace

bool TouchRule::meets_extra_condition(double displacement) {
  return displacement <= MUG_DISPLACEMENT_SUCCESS_THRESH;
}

void TouchRule::declare(ConstantBinder& constants) {
  constants.fixed({{"MUG_DISPLACEMENT_PENALTY_COEF", MUG_DISPLACEMENT_PENALTY_COEF},
                   {"MUG_DISPLACEMENT_SUCCESS_THRESH", MUG_DISPLACEMENT_SUCCESS_THRESH}});
}

void TouchRule::describe(TaskInfo& info) const {
  info.reward_terms = reward_terms_of(Reward{.form = form_});
  info.answer =
      "the first cup within GOAL_THRESH of which the robot rests in the manipulation phase, the "
      "nearest one if there are several; its slot";
}

void TouchRule::bind(const Bindings& bindings) {
  displacement_ = bindings.memory->add<double>("mug_max_displacement", 1, "m");
  if (!form_.shoving) return;
  mug_max_displacement_ = bindings.outputs->add<float>(
      "mug_max_displacement", 1, "m", "farthest that a mug was shoved since it appeared");
  is_mug_displacement_ok_ = bindings.outputs->add<std::uint8_t>("is_mug_displacement_ok");
}

// --- success ---

ShellGame::Outcome TouchRule::judge(const ShellGame& game, int env, const Eigen::Vector3d& goal,
                                    double displacement) const {
  const Eigen::Vector3d offset = goal - game.tcp_pos(env);
  displacement_[env] = displacement;
  if (form_.shoving) {
    mug_max_displacement_[env] = static_cast<float>(displacement);
    is_mug_displacement_ok_[env] = meets_extra_condition(displacement) ? 1 : 0;
  }
  return {.obj_to_goal = offset,
          .placed = offset.norm() <= goal_thresh_,
          .still = robot_is_static(game.state(), env),
          .extra_condition = meets_extra_condition(displacement)};
}

int TouchRule::touched_mug(const ShellGame& game, int env) const {
  const State& state = game.state();
  if (!game.is_manipulation(env) || !robot_is_static(state, env)) return -1;
  return touched_object(state.prop_pos_of(env, 0), kCups, state.tcp_pos.row(env), goal_thresh_);
}

// --- reward ---

double TouchRule::Reward::compute() {
  reaching = 1 - real::tanh(5 * distance);
  stillness = 1 - real::tanh(5 * arm_speed);
  shift = MUG_DISPLACEMENT_PENALTY_COEF * real::tanh(10 * displacement);
  if (success) return kTouchReward;
  if (!manipulation) return 0;
  return reaching + (placed ? stillness + (robot_static ? 1 : 0) : 0) - shift;
}

void TouchRule::dense_reward(const ShellGame& game, Range envs, FloatRows out) const {
  game.reward_dict().write(envs, out, [&](int env) {
    Reward reward{.distance = game.obj_to_goal(env).norm(),
                  .displacement = displacement_[env],
                  .form = form_};
    game.fill_in(env, reward);
    return reward;
  });
}

}  // namespace engram::tasks
