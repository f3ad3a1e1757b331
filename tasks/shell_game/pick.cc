#include "tasks/shell_game/pick.h"

#include <string>

#include "core/math/real_functions.h"
#include "tasks/common/variant.h"
#include "tasks/shell_game/annotator.h"
#include "tasks/shell_game/game.h"
#include "tasks/shell_game/pick_expert.h"
#include "tasks/shell_game/pick_params.h"
#include "tasks/shell_game/pick_rl.h"

namespace engram::tasks {
namespace {

constexpr double kGripperOpening = 0.08;  // m
constexpr double kMinRise = 0.01;         // m, of the ball where its slot is in the goal region
const Eigen::Vector3d kHandleFromMug(-HANDLE_OFFSET_X, HANDLE_OFFSET_Y, 0);  // m, world axes

template <class Visitor>
void list_terms(Visitor& row, const PickInputs& in, const PickTerms& terms) {
  row.term("reaching_reward", "", terms.reaching);
  row.term("open_gripper_reward", "", terms.open);
  row.term("grasp_reward", "", terms.grasp);
  row.term("reached_status", "", terms.reached);
  row.term("info[\"is_grasped\"]", "", in.grasped);
  row.term("place_reward", "", terms.place);
  row.term("static_reward", "", terms.stillness);
  row.term("tcp_to_handle_dist", "m", in.to_handle);
  row.term("tcp_to_obj_dist", "m", in.to_mug);
  row.term("obj_to_goal_dist", "m", in.to_goal);
  row.term("info[\"is_obj_placed\"]", "", in.placed);
  row.term("gripper_width", "m", in.gripper_width);
  row.term("dx_handle", "m", in.handle_offset.x());
  row.term("dy_handle", "m", in.handle_offset.y());
  row.term("dz_handle", "m", in.handle_offset.z());
}

class Pick final : public ShellGame {
 public:
  Pick(const RegistryEntry& entry, const PickParams& params)
      : ShellGame(entry, params,
                  {.frozen = false,
                   .success_reward = kPickSuccessReward,
                   .orientations = {&kHandleTowardsRobot, 1}}),
        pick_(params),
        choice_(info_, params),
        ball_(add_red_ball()),
        goal_(add_goal_site(params.GOAL_THRESH)),
        expert_(*this, params),
        annotator_({.game = *this, .skill = ShellGameAnnotator::Skill::kPick, .ball = ball_}) {
    info_.termination = Termination::kSuccess;
    info_.phases = cue_manipulation_phases();
    info_.answer =
        "the first cup that is moved by more than 4 mm, with mug_at_goal by more than half the "
        "height to which it has to be lifted; its slot";
    info_.reward_terms = reward_terms_of([](auto& row) { list_terms(row, {}, {}); });
    declare_state(*this);
  }

  void bind(const Bindings& bindings) override {
    ShellGame::bind(bindings);
    is_grasped_ = bindings.outputs->add_privileged<std::uint8_t>("is_grasped");
    item_ = choice_.item(bindings);
    require_goal(pick_, item_);
    answer_distance_ = pick_.answer_distance(item_);
    if (item_ == GoalItem::kMug) {
      expert_.lift_mug(pick_.lift());
    } else {
      expert_.lift_ball(pick_.goal_height, pick_.GOAL_THRESH);
    }
  }

  // --- phases ---

  void advance(Range envs) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      if (engine_.state->elapsed[env] == 0) place_sphere(env, goal_, goal_pos(env));
      update_free_mugs(env, ball_, /*lifted_along=*/item_ == GoalItem::kBall);
    }
  }

  // --- success ---

  void evaluate(Range envs) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      engine_.oracle_info[env] = target_[env];
      is_grasped_[env] = is_grasping(*engine_.state, env, target_[env]) ? 1 : 0;
      const Eigen::Vector3d offset = goal_pos(env) - item_pos(env);
      set_outcome(env, {.obj_to_goal = offset,
                        .placed = offset.norm() <= pick_.placed_distance(item_) && is_lifted(env),
                        .still = robot_is_static(*engine_.state, env)});
      note_answer(env, moved_mug(env, answer_distance_));
    }
  }

  // --- reward ---

  void dense_reward(Range envs, FloatRows out) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      PickInputs in;
      in.handle_offset = handle_pos(env) - tcp_pos(env);
      in.to_handle = in.handle_offset.norm();
      in.to_mug = (mugs_.pos(env, target_[env]) - tcp_pos(env)).norm();
      in.to_goal = obj_to_goal(env).norm();
      in.gripper_width = gripper_width(env);
      in.grasped = is_grasped_[env] != 0;
      fill_in(env, in);
      const PickTerms terms = pick_reward(in);
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
    row.field("handle_pos", 3, "m", "nominal grip of that mug", [&] { return handle_pos(env); });
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
  Eigen::Vector3d handle_pos(int env) const {
    return mugs_.pos(env, target_[env]) + kHandleFromMug;
  }
  // Position of what has to come to the goal.
  Eigen::Vector3d item_pos(int env) const {
    return item_ == GoalItem::kMug ? mugs_.pos(env, target_[env]) : prop_pos(env, ball_);
  }
  // A ball that lies in the goal region from the start has to be lifted all the same.
  bool is_lifted(int env) const {
    const double rise = prop_pos(env, ball_).z() - params().BALL_RADIUS;
    return item_ == GoalItem::kMug || rise >= kMinRise;
  }
  double gripper_width(int env) const {
    const double* qpos = engine_.state->qpos.row(env);
    return qpos[kArmJoints] + qpos[kArmJoints + 1];
  }

  PickParams pick_;
  GoalChoice choice_;
  GoalItem item_ = GoalItem::kBall;
  double answer_distance_ = 0;  // m
  int ball_;
  int goal_;
  Column<std::uint8_t> is_grasped_;
  PickExpert expert_;
  ShellGameAnnotator annotator_;
};

}  // namespace

PickTerms pick_reward(const PickInputs& in) {
  PickTerms terms;
  terms.reaching = 1 - real::tanh(10 * in.to_handle);
  terms.place = 1 - real::tanh(5 * in.to_goal);
  terms.stillness = 1 - real::tanh(5 * in.arm_speed);
  terms.reached = in.to_handle <= kPickReach;
  terms.open = terms.reached ? 0 : in.gripper_width / kGripperOpening;
  terms.grasp = terms.reached && in.grasped ? 1 : 0;
  if (!in.manipulation) return terms;
  if (in.success) {
    terms.reward = kPickSuccessReward;
    return terms;
  }
  terms.reward = 3 * terms.reaching + 1.5 * terms.open + (terms.reached ? 2 : 0) + 10 * terms.grasp;
  if (!in.grasped) return terms;
  terms.reward += 30 * terms.place;
  if (in.placed) terms.reward += 5 * (terms.stillness + (in.robot_static ? 1 : 0));
  return terms;
}

namespace {

constexpr auto kRows = rows_of(kPickVariants);

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
    .tasks = kRows,
    .make = make_pick,
    .expectations = {.min_reward = 0, .max_reward = 0.6667, .goal_for_people = true, .hides = true},
    .memory = {.irrelevant = CounterfactualChange::kDraw, .irrelevant_draw = "cue_steps"}};

}  // namespace engram::tasks
