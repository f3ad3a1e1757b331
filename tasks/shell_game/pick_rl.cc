#include "tasks/shell_game/pick_rl.h"

#include <array>

#include "core/base/index.h"
#include "core/math/real_functions.h"
#include "tasks/common/variant.h"
#include "tasks/shell_game/annotator.h"
#include "tasks/shell_game/game.h"
#include "tasks/shell_game/pick_expert.h"
#include "tasks/shell_game/pick_params.h"

namespace engram::tasks {
namespace {

// The original's stance by slot of the ball, an index of kHandleTurns.
constexpr std::array<int, kCups> kOrientationBySlot = {0, 2, 1};

template <class Visitor>
void list_terms(Visitor& row, const MugPickInputs& in, const MugPickTerms& terms) {
  row.term("reaching_reward", "", terms.reaching);
  row.term("reached_status", "", terms.reached);
  row.term("info[\"is_grasped\"]", "", in.grasped);
  row.term("place_reward", "", terms.place);
  row.term("static_reward", "", terms.stillness);
  row.term("tcp_to_obj_dist", "m", in.offset.norm());
  row.term("obj_to_goal_dist", "m", in.to_goal);
  row.term("info[\"is_obj_placed\"]", "", in.placed);
  row.term("dx", "m", in.offset.x());
  row.term("dy", "m", in.offset.y());
  row.term("dz", "m", in.offset.z());
}

class MugPick final : public ShellGame {
 public:
  MugPick(const RegistryEntry& entry, const PickParams& params)
      : ShellGame(
            entry, params,
            {.frozen = false, .success_reward = kPickSuccessReward, .orientations = kHandleTurns}),
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
        ball_(add_red_ball()),
        goal_(add_goal_site(params.GOAL_THRESH)),
        expert_(*this, params),
        annotator_({.game = *this, .skill = ShellGameAnnotator::Skill::kPick, .ball = ball_}) {
    info_.phases = cue_manipulation_phases();
    info_.answer =
        "the first cup that is moved by more than 4 mm, from where on it may show what is under "
        "it; its slot";
    info_.reward_terms = reward_terms_of([](auto& row) { list_terms(row, {}, {}); });
    declare_state(*this);
  }

  void bind(const Bindings& bindings) override {
    ShellGame::bind(bindings);
    is_grasped_ = bindings.outputs->add_privileged<std::uint8_t>("is_grasped");
    expert_.lift_mug(pick_.lift());
    if (upstream_handle_.is_on(bindings)) reveal_answer();
  }

  // --- sampling ---

  void reset(const Episode& episode) override {
    ShellGame::reset(episode);
    const int env = episode.env();
    const int by_slot = kOrientationBySlot[at(target_[env])];
    const bool follows = upstream_handle_.is_on(engine_);
    mugs_.choose_orientation(
        env, handle_.sample_from(episode, follows ? Interval<int>{by_slot, by_slot}
                                                  : Interval<int>{0, handle_.high()}));
  }

  // --- phases ---

  void advance(Range envs) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      if (engine_.state->elapsed[env] == 0) place_sphere(env, goal_, goal_pos(env));
      update_free_mugs(env, ball_);
    }
  }

  // --- success ---

  void evaluate(Range envs) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      engine_.oracle_info[env] = target_[env];
      is_grasped_[env] = is_grasping(*engine_.state, env, target_[env]) ? 1 : 0;
      const Eigen::Vector3d offset = goal_pos(env) - mugs_.pos(env, target_[env]);
      set_outcome(env, {.obj_to_goal = offset,
                        .placed = offset.norm() <= pick_.placed_distance(GoalItem::kMug),
                        .still = robot_is_static(*engine_.state, env)});
      note_answer(env, moved_mug(env, pick_.answer_distance(GoalItem::kMug)));
    }
  }

  // --- reward ---

  void dense_reward(Range envs, FloatRows out) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      MugPickInputs in;
      in.offset = mugs_.pos(env, target_[env]) - tcp_pos(env);
      in.to_goal = obj_to_goal(env).norm();
      in.grasped = is_grasped_[env] != 0;
      fill_in(env, in);
      const MugPickTerms terms = mug_pick_reward(in);
      reward_dict().note(env, [&](auto& row) { list_terms(row, in, terms); });
      *out.row(env) = static_cast<float>(terms.reward);
    }
  }

  // --- observation ---

  void observe(Range envs, FloatRows out) override { write_state(*this, envs, out); }

  template <class Visitor>
  void state_row(Visitor& row, int env) const {
    row.field("goal_pos", 3, "m", "centre of the goal region", [&] { return goal_pos(env); });
    row.field("obj_pose", 7, "m", "of the mug over the ball",
              [&](RowWriter& out) { add_pose(env, target_[env], out); });
    row.field("ball_pose", 7, "m", "of the red ball",
              [&](RowWriter& out) { add_pose(env, ball_, out); });
    row.field("oracle_info", 1, "", "slot of the ball", [&] { return target_[env]; });
    row.field("is_grasped", 1, "", "of that mug", [&] { return is_grasped_[env]; });
  }

  // --- expert ---

  const Expert& expert() const override { return expert_; }
  const Annotator* annotator() const override { return &annotator_; }

 private:
  Eigen::Vector3d goal_pos(int env) const {
    return mugs_.slot_pos(env, target_[env], params().BALL_RADIUS) + pick_.goal_from_ball();
  }

  PickParams pick_;
  IntegerVariable handle_;
  TaskOption upstream_handle_;
  int ball_;
  int goal_;
  Column<std::uint8_t> is_grasped_;
  PickExpert expert_;
  ShellGameAnnotator annotator_;
};

}  // namespace

MugPickTerms mug_pick_reward(const MugPickInputs& in) {
  MugPickTerms terms;
  const double distance = in.offset.norm();
  terms.reaching = 1 - real::tanh(10 * distance);
  terms.place = 1 - real::tanh(5 * in.to_goal);
  terms.stillness = 1 - real::tanh(5 * in.arm_speed);
  terms.reached = distance <= kPickReach;
  if (!in.manipulation) return terms;
  if (in.success) {
    terms.reward = kPickSuccessReward;
    return terms;
  }
  terms.reward = 3 * terms.reaching;
  if (!terms.reached) return terms;
  terms.reward += 2 + 30 * terms.place;
  if (in.placed) terms.reward += 5 * (terms.stillness + (in.robot_static ? 1 : 0));
  return terms;
}

std::unique_ptr<Task> make_mug_pick(const RegistryEntry& entry, const ConstantTable& constants) {
  return make_variant<MugPick, kPickVariants>(entry, constants);
}

}  // namespace engram::tasks
