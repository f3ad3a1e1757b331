#include "tasks/shell_game/pick_rl.h"

#include <array>

#include "core/base/index.h"
#include "core/math/real_functions.h"
#include "tasks/common/variant.h"
#include "tasks/shell_game/goal_game.h"
#include "tasks/shell_game/pick_expert.h"
#include "tasks/shell_game/pick_params.h"

namespace engram::tasks {
namespace {

// The original's stance by slot of the ball, an index of kHandleTurns.
constexpr std::array<int, kCups> kOrientationBySlot = {0, 2, 1};

class MugPick final : public GoalGame {
 public:
  MugPick(const RegistryEntry& entry, const PickParams& params)
      : GoalGame(
            entry, params,
            {.frozen = false, .success_reward = kPickSuccessReward, .orientations = kHandleTurns},
            {.skill = ShellGameAnnotator::Skill::kPick, .from_ball = params.goal_from_ball()}),
        pick_(params),
        handle_(RandomVariables(info_.random_variables)
                    .integer("handle", {0, static_cast<int>(kHandleTurns.size()) - 1}, "",
                             "direction of the handles: 167, 170 or 173 degrees")),
        upstream_handle_(
            TaskOptions(info_.options)
                .on_off("upstream_handle",
                        "1: handles point where the ball's slot says, 167, 173 or 170 degrees, in "
                        "every episode whose handle is not pinned",
                        /*original=*/true)),
        expert_(*this, params) {
    info_.answer =
        "the first cup that is moved by more than 4 mm, from where on it may show what is under "
        "it; its slot";
    info_.reward_terms = reward_terms_of(MugPickReward{});
  }

  void bind(const Bindings& bindings) override {
    GoalGame::bind(bindings);
    set_item(GoalItem::kMug, pick_.answer_distance(GoalItem::kMug));
    expert_.lift_mug(pick_.lift());
    if (upstream_handle_.is_on(bindings)) reveal_answer();
  }

  void reset(const Episode& episode) override {
    ShellGame::reset(episode);
    const int env = episode.env();
    const int by_slot = kOrientationBySlot[at(target_[env])];
    const bool follows = upstream_handle_.is_on(engine_);
    mugs_.choose_orientation(
        env, handle_.sample_from(episode, follows ? Interval<int>{by_slot, by_slot}
                                                  : Interval<int>{0, handle_.high()}));
  }

  void dense_reward(Range envs, FloatRows out) override {
    reward_dict().write(envs, out, [&](int env) {
      MugPickReward reward{.to_goal = obj_to_goal(env).norm(),
                           .offset = mug_pos(env) - tcp_pos(env),
                           .grasped = is_grasped(env)};
      fill_in(env, reward);
      return reward;
    });
  }

  const Expert& expert() const override { return expert_; }

 private:
  PickParams pick_;
  IntegerVariable handle_;
  TaskOption upstream_handle_;
  PickExpert expert_;
};

}  // namespace

double MugPickReward::compute() {
  const double distance = offset.norm();
  reaching = 1 - real::tanh(10 * distance);
  place = 1 - real::tanh(5 * to_goal);
  stillness = 1 - real::tanh(5 * arm_speed);
  reached = distance <= kPickReach;
  if (!manipulation) return 0;
  if (success) return kPickSuccessReward;
  double reward = 3 * reaching;
  if (!reached) return reward;
  reward += 2 + 30 * place;
  if (placed) reward += 5 * (stillness + (robot_static ? 1 : 0));
  return reward;
}

std::unique_ptr<Task> make_mug_pick(const RegistryEntry& entry, const ConstantTable& constants) {
  return make_variant<MugPick, kPickVariants>(entry, constants);
}

}  // namespace engram::tasks
