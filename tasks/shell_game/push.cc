#include "tasks/shell_game/push.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "core/math/real_functions.h"
#include "core/task/option_check.h"
#include "tasks/common/phase_budget.h"
#include "tasks/common/variant.h"
#include "tasks/shell_game/goal_game.h"
#include "tasks/shell_game/push_expert.h"

namespace engram::tasks {
namespace {

// --- parameters ---

constexpr double kReachedDistance = 0.08;  // m
constexpr double kSuccessReward = 4;
constexpr double kGoalAhead = 0.1;  // m, of the ball

// Least requirements of a push.
constexpr double kMinTravel = 0.001;  // m
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
    return item == GoalItem::kMug ? way : std::max(way, kMinBallTravel);
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

constexpr std::array<PushParams, 2> kPushVariants = {{
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

class Push final : public GoalGame, public OptionCheck {
 public:
  Push(const RegistryEntry& entry, const PushParams& params)
      : GoalGame(entry, params, {.success_reward = kSuccessReward},
                 {.skill = ShellGameAnnotator::Skill::kPush,
                  .from_ball = params.goal_from_ball(),
                  .static_speed = params.static_speed}),
        push_(params),
        choice_(info_, params),
        expert_(*this, params) {
    info_.termination = Termination::kSuccess;
    info_.answer = params.task.is_rl()
                       ? "the first cup that is moved by more than half the least way to the goal "
                         "region; its slot"
                       : "the first cup that is moved by more than 4 mm, with mug_at_goal by more "
                         "than half the least way to the goal region; its slot";
    info_.reward_terms = reward_terms_of(PushReward{.lists_static = !params.task.is_rl()});
  }

  void check_options(std::span<const double> options) const override {
    require_goal(push_, choice_.item(options));
  }

  void bind(const Bindings& bindings) override {
    GoalGame::bind(bindings);
    check_options(bindings.options);
    const GoalItem item = choice_.item(bindings.options);
    set_item(item, push_.answer_distance(item));
    const double travel = push_.travel(item);
    expert_.set_goal(item, travel, push_.placed_distance(item), kGoalAhead - travel);
  }

  void dense_reward(Range envs, FloatRows out) override {
    reward_dict().write(envs, out, [&](int env) {
      PushReward reward{.distance = (mug_pos(env) - tcp_pos(env)).norm(),
                        .to_goal = obj_to_goal(env).norm(),
                        .lists_static = !push_.task.is_rl()};
      fill_in(env, reward);
      return reward;
    });
  }

  const Expert& expert() const override { return expert_; }

 private:
  PushParams push_;
  GoalChoice choice_;
  PushExpert expert_;
};

}  // namespace

double PushReward::compute() {
  reaching = 1 - real::tanh(10 * distance);
  place = 1 - real::tanh(5 * to_goal);
  stillness = 1 - real::tanh(5 * arm_speed);
  reached = distance <= kReachedDistance;
  if (!manipulation) return 0;
  if (success) return kSuccessReward;
  double reward = reaching;
  if (reached) reward += 2 * place;
  if (placed) reward += 0.2 * (stillness + (robot_static ? 1 : 0));
  return reward;
}

constexpr auto kPushRows = rows_of(kPushVariants);

const Family kShellGamePush = {
    .name = "ShellGamePush",
    .memory_type = "Spatial",
    .instruction = "Observe which cup hides the ball, wait, then push that cup forward.",
    .tasks = kPushRows,
    .make = make_variant<Push, kPushVariants>,
    .expectations = {.min_reward = 0, .max_reward = 0.8, .goal_for_people = true, .hides = true},
    .memory = {.irrelevant = CounterfactualChange::kDraw, .irrelevant_draw = "cue_steps"}};

}  // namespace engram::tasks
