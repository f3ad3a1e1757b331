#include "tasks/shell_game/push.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "core/math/real_functions.h"
#include "tasks/common/phase_budget.h"
#include "tasks/common/variant.h"
#include "tasks/shell_game/annotator.h"
#include "tasks/shell_game/game.h"
#include "tasks/shell_game/push_expert.h"

namespace engram::tasks {
namespace {

// --- parameters ---

constexpr double kReachedDistance = 0.08;  // m
constexpr double kSuccessReward = 4;
constexpr double kGoalAhead = 0.1;  // m, of the ball

// Least requirements of a push.
constexpr double kMinTravel = 0.001;  // m
constexpr double kMinPush = 0.01;     // m, where the ball's slot is in the goal region
constexpr int kTimeToPush = 19;       // control steps

struct PushParams : ShellGameParams {
  double goal_height = 0.03;  // m, of the goal's centre above the ball's
  double static_speed = 0.3;  // rad/s

  Eigen::Vector3d goal_from_ball() const { return {kGoalAhead, 0, goal_height}; }
  // Vector to the goal's centre from the mug or the ball in its slot, m.
  Eigen::Vector3d offset(GoalItem item) const {
    if (item == GoalItem::kBall) return goal_from_ball();
    return goal_from_ball() + Eigen::Vector3d(0, 0, BALL_RADIUS - resting_height());
  }
  // Distance by which the mug has to be pushed, m.
  double travel(GoalItem item) const {
    const double height = offset(item).z();
    const double reach = placed_distance(item);
    const double way = offset(item).x() - std::sqrt(reach * reach - height * height);
    return item == GoalItem::kMug ? way : std::max(way, kMinPush);
  }
  // A mug that is moved farther is the robot's answer, m.
  double answer_distance(GoalItem item) const {
    if (item == GoalItem::kBall) return kLiftThatShows;
    return (offset(item).norm() - placed_distance(item)) / 2;
  }

  // Why no policy could succeed, or all would; empty if neither is so.
  std::string contradiction(GoalItem item) const;
  void check(int horizon) const;
};

constexpr std::array<PushParams, 2> kVariants = {{
    {{.task = {"ShellGamePush-VLA-v0", 30, Split::kShort}, .GOAL_THRESH = 0.06}},
    {{.task =
          {.id = "ShellGamePush-v0", .horizon = 90, .split = Split::kRl, .memory_type = "Object"},
      .GOAL_THRESH = 0.05,
      .CUE_PHASE_STEPS = {5, 5},
      .MUG_SCALE = 1,
      .first_success = 1},
     0.0242722,
     0.2},
}};

std::string PushParams::contradiction(GoalItem item) const {
  const double placed = placed_distance(item);
  const double height = offset(item).z();
  if (item == GoalItem::kBall) {
    if (placed - height >= kMinTravel) return {};
    return "balls never are in the goal region: GOAL_THRESH = " + in_millimetres(placed) +
           ", and its centre is " + in_millimetres(height) + " above a ball's";
  }
  if (std::abs(height) >= placed) {
    return "cups never are in the goal region: 1.6 x GOAL_THRESH = " + in_millimetres(placed) +
           ", and its centre is " + in_millimetres(height) + " above a cup's origin";
  }
  if (travel(item) >= kMinTravel) return {};
  return "cups are in the goal region from the start: 1.6 x GOAL_THRESH = " +
         in_millimetres(placed) + ", and its centre is " + in_millimetres(offset(item).norm()) +
         " from a cup that nobody has moved";
}

void PushParams::check(int horizon) const {
  check_mugs(*this, kUpsideDown);
  require_possible_goal(*this);
  check_horizon(horizon, {{"CUE_PHASE_STEPS", CUE_PHASE_STEPS.high}}, kTimeToPush);
}

template <class Visitor>
void list_terms(Visitor& row, bool rl, const PushInputs& in, const PushTerms& terms) {
  row.term("reaching_reward", "", terms.reaching);
  row.term("static_reward", "", terms.stillness);
  if (!rl) row.term("is_robot_static", "", in.robot_static);
  row.term("place_reward", "", terms.place);
  row.term("tcp_to_obj_dist", "m", in.distance);
  row.term("obj_to_goal_dist", "m", in.to_goal);
  row.term("info[\"is_obj_placed\"]", "", in.placed);
  row.term("reached_status", "", terms.reached);
}

class Push final : public ShellGame {
 public:
  Push(const RegistryEntry& entry, const PushParams& params)
      : ShellGame(entry, params, {.success_reward = kSuccessReward}),
        push_(params),
        choice_(info_, params),
        ball_(add_red_ball()),
        goal_(add_goal_site(params.GOAL_THRESH)),
        expert_(*this, params),
        annotator_({.game = *this, .skill = ShellGameAnnotator::Skill::kPush, .ball = ball_}) {
    info_.termination = Termination::kSuccess;
    info_.phases = cue_manipulation_phases();
    info_.answer = params.task.is_rl()
                       ? "the first cup that is moved by more than half the least way to the goal "
                         "region; its slot"
                       : "the first cup that is moved by more than 4 mm, with mug_at_goal by more "
                         "than half the least way to the goal region; its slot";
    info_.reward_terms =
        reward_terms_of([&](auto& row) { list_terms(row, params.task.is_rl(), {}, {}); });
    declare_state(*this);
  }

  void bind(const Bindings& bindings) override {
    ShellGame::bind(bindings);
    item_ = choice_.item(bindings);
    require_goal(push_, item_);
    answer_distance_ = push_.answer_distance(item_);
    const double travel = push_.travel(item_);
    expert_.set_goal(item_, travel, push_.placed_distance(item_), kGoalAhead - travel);
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
      const Eigen::Vector3d offset = goal_pos(env) - item_pos(env);
      set_outcome(env, {.obj_to_goal = offset,
                        .placed = offset.norm() <= push_.placed_distance(item_) && is_pushed(env),
                        .still = robot_is_static(*engine_.state, env, push_.static_speed)});
      note_answer(env, moved_mug(env, answer_distance_));
    }
  }

  // --- reward ---

  void dense_reward(Range envs, FloatRows out) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      PushInputs in;
      in.distance = (mugs_.pos(env, target_[env]) - tcp_pos(env)).norm();
      in.to_goal = obj_to_goal(env).norm();
      fill_in(env, in);
      const PushTerms terms = push_reward(in);
      reward_dict().note(env, [&](auto& row) { list_terms(row, push_.task.is_rl(), in, terms); });
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
  }

  // --- expert ---

  const Expert& expert() const override { return expert_; }
  const Annotator* annotator() const override { return &annotator_; }

 private:
  Eigen::Vector3d goal_pos(int env) const {
    return mugs_.slot_pos(env, target_[env], params().BALL_RADIUS) + push_.goal_from_ball();
  }
  // Position of what has to come to the goal.
  Eigen::Vector3d item_pos(int env) const {
    return item_ == GoalItem::kMug ? mugs_.pos(env, target_[env]) : prop_pos(env, ball_);
  }
  // A ball that lies in the goal region from the start has to be pushed all the same.
  bool is_pushed(int env) const {
    const double way = prop_pos(env, ball_).x() - mugs_.base(env).x();
    return item_ == GoalItem::kMug || way >= kMinPush;
  }

  PushParams push_;
  GoalChoice choice_;
  GoalItem item_ = GoalItem::kBall;
  double answer_distance_ = 0;  // m
  int ball_;
  int goal_;
  PushExpert expert_;
  ShellGameAnnotator annotator_;
};

}  // namespace

PushTerms push_reward(const PushInputs& in) {
  PushTerms terms;
  terms.reaching = 1 - real::tanh(10 * in.distance);
  terms.place = 1 - real::tanh(5 * in.to_goal);
  terms.stillness = 1 - real::tanh(5 * in.arm_speed);
  terms.reached = in.distance <= kReachedDistance;
  if (!in.manipulation) return terms;
  if (in.success) {
    terms.reward = kSuccessReward;
    return terms;
  }
  terms.reward = terms.reaching;
  if (terms.reached) terms.reward += 2 * terms.place;
  if (in.placed) terms.reward += 0.2 * (terms.stillness + (in.robot_static ? 1 : 0));
  return terms;
}

constexpr auto kRows = rows_of(kVariants);

const Family kShellGamePush = {
    .name = "ShellGamePush",
    .memory_type = "Spatial",
    .instruction = "Observe which cup hides the ball, wait, then push that cup forward.",
    .tasks = kRows,
    .make = make_variant<Push, kVariants>,
    .expectations = {.min_reward = 0, .max_reward = 0.8, .goal_for_people = true, .hides = true},
    .memory = {.irrelevant = CounterfactualChange::kDraw, .irrelevant_draw = "cue_steps"}};

}  // namespace engram::tasks
