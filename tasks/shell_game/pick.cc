#include "tasks/shell_game/pick.h"

#include <string>

#include "core/math/real_functions.h"
#include "core/task/option_check.h"
#include "tasks/common/variant.h"
#include "tasks/shell_game/goal_game.h"
#include "tasks/shell_game/pick_expert.h"
#include "tasks/shell_game/pick_params.h"
#include "tasks/shell_game/pick_rl.h"

namespace engram::tasks {
namespace {

constexpr double kGripperOpening = 0.08;                                     // m
const Eigen::Vector3d kHandleFromMug(-HANDLE_OFFSET_X, HANDLE_OFFSET_Y, 0);  // m, world axes

class Pick final : public GoalGame, public OptionCheck {
 public:
  Pick(const RegistryEntry& entry, const PickParams& params)
      : GoalGame(entry, params,
                 {.frozen = false,
                  .success_reward = kPickSuccessReward,
                  .orientations = {&kHandleTowardsRobot, 1}},
                 {.skill = ShellGameAnnotator::Skill::kPick,
                  .from_ball = params.goal_from_ball(),
                  .handle = kHandleFromMug}),
        pick_(params),
        choice_(info_, params),
        expert_(*this, params) {
    info_.termination = Termination::kSuccess;
    info_.answer =
        "the first cup that is moved by more than 4 mm, with mug_at_goal by more than half the "
        "height to which it has to be lifted; its slot";
    info_.reward_terms = reward_terms_of(PickReward{});
  }

  void check_options(std::span<const double> options) const override {
    require_goal(pick_, choice_.item(options));
  }

  void bind(const Bindings& bindings) override {
    GoalGame::bind(bindings);
    check_options(bindings.options);
    const GoalItem item = choice_.item(bindings.options);
    set_item(item, pick_.answer_distance(item));
    if (item == GoalItem::kMug) {
      expert_.lift_mug(pick_.lift());
    } else {
      expert_.lift_ball(pick_.goal_height, pick_.GOAL_THRESH);
    }
  }

  void dense_reward(Range envs, FloatRows out) override {
    reward_dict().write(envs, out, [&](int env) {
      const Eigen::Vector3d to_handle = handle_pos(env) - tcp_pos(env);
      PickReward reward{.to_handle = to_handle.norm(),
                        .to_goal = obj_to_goal(env).norm(),
                        .gripper_width = gripper_width(env),
                        .grasped = is_grasped(env),
                        .to_mug = (mug_pos(env) - tcp_pos(env)).norm(),
                        .handle_offset = to_handle};
      fill_in(env, reward);
      return reward;
    });
  }

  const Expert& expert() const override { return expert_; }

 private:
  PickParams pick_;
  GoalChoice choice_;
  PickExpert expert_;
};

}  // namespace

double PickReward::compute() {
  reaching = 1 - real::tanh(10 * to_handle);
  place = 1 - real::tanh(5 * to_goal);
  stillness = 1 - real::tanh(5 * arm_speed);
  reached = to_handle <= kPickReach;
  open = reached ? 0 : gripper_width / kGripperOpening;
  grasp = reached && grasped ? 1 : 0;
  if (!manipulation) return 0;
  if (success) return kPickSuccessReward;
  double reward = 3 * reaching + 1.5 * open + (reached ? 2 : 0) + 10 * grasp;
  if (!grasped) return reward;
  reward += 30 * place;
  if (placed) reward += 5 * (stillness + (robot_static ? 1 : 0));
  return reward;
}

namespace {

constexpr auto kPickRows = rows_of(kPickVariants);

// The RL task has other rules.
std::unique_ptr<Task> make_pick(const RegistryEntry& entry, const ConstantTable& constants) {
  const bool rl = find_variant(kPickVariants, entry.base).task.is_rl();
  return rl ? make_mug_pick(entry, constants) : make_variant<Pick, kPickVariants>(entry, constants);
}

}  // namespace

const Family kShellGamePick = {
    .name = "ShellGamePick",
    .memory_type = "Spatial",
    .instruction = "Observe which cup hides the ball, wait, then pick up that cup and lift it.",
    .tasks = kPickRows,
    .make = make_pick,
    .expectations = {.min_reward = 0, .max_reward = 0.6667, .goal_for_people = true, .hides = true},
    .memory = {.irrelevant = CounterfactualChange::kDraw, .irrelevant_draw = "cue_steps"}};

}  // namespace engram::tasks
