#include "tasks/intercept/deflect.h"

#include <algorithm>
#include <array>

#include "core/math/real_functions.h"
#include "mjcf/target_disc.h"
#include "tasks/common/family_base.h"
#include "tasks/common/poses.h"
#include "tasks/common/reward_dict.h"
#include "tasks/common/variant.h"
#include "tasks/intercept/ball_game.h"
#include "tasks/intercept/expert.h"

namespace engram::tasks {
namespace {

using Vector = Eigen::Vector3d;

// --- parameters ---

struct Params {
  TaskSpec task;
  BallParams ball;
  double GOAL_RADIUS = 0.1;  // m

  void declare(ConstantBinder& constants) {
    ball.declare(constants);
    constants.real("GOAL_RADIUS", GOAL_RADIUS, {0.02, 0.2}, "m",
                   "how near the target's centre the ball has to be");
  }
  void check(int horizon) const { ball.check(horizon); }
};

constexpr std::array<Params, 6> kVariants = {{
    {{"InterceptFast-VLA-v0", 60, Split::kShort, 0.85}, {{0.75, 1.0}}},
    {{"InterceptMedium-VLA-v0", 60, Split::kShort, 0.90}, {{0.5, 0.75}}},
    {{"InterceptSlow-VLA-v0", 60, Split::kShort}, {{0.25, 0.5}}},
    {{"InterceptSlow-v0", 90, Split::kRl}, rl_ball(0.25, 0.5)},
    {{"InterceptMedium-v0", 90, Split::kRl}, rl_ball(0.5, 0.75)},
    {{"InterceptFast-v0", 90, Split::kRl}, rl_ball(0.75, 1.0)},
}};

constexpr double kStartRadii = 2;          // of the ball, high: it falls onto the table
constexpr double kGoalAhead = 0.2;         // m, in x, from the ball's start
constexpr double kGoalSpan = 0.2;          // m, in y, to either side
constexpr double kGoalHeight = 0.001;      // m
constexpr double kHitGap = 0.05;           // m: behind the ball, as seen from the goal
constexpr double kReachedDistance = 0.04;  // m
constexpr double kSuccessReward = 30;
constexpr mjcf::Rgba kTargetRed = {194 / 255.0, 19 / 255.0, 22 / 255.0, 1};

constexpr int kGoalProp = 1;

class Intercept final : public BallGame {
 public:
  Intercept(const RegistryEntry& entry, const Params& params)
      : BallGame(entry, params.ball, kStartRadii * params.ball.BALL_RADIUS,
                 InterceptGoal::kDeflect),
        params_(params),
        goal_y_(RandomVariables(info_.random_variables)
                    .real("goal_y", {-kGoalSpan, kGoalSpan}, "m", "where the target lies")),
        expert_({.engine = engine_,
                 .goal_prop = kGoalProp,
                 .ball = params.ball,
                 .goal_radius = params.GOAL_RADIUS}) {
    info_.success_reward = kSuccessReward;
    info_.reward_terms = reward_terms_of(InterceptReward{});
    declare_state(*this);
    scene_.props.push_back(mjcf::target_disc("goal_region", params.GOAL_RADIUS, kTargetRed));
  }

  void bind(const Bindings& bindings) override {
    BallGame::bind(bindings);
    reached_ = bindings.memory->add<std::uint8_t>("reached");
  }

  // --- sampling ---

  void reset(const Episode& episode) override {
    const int env = episode.env();
    BallGame::reset(episode);
    const double goal[3] = {ball(env).x() + kGoalAhead, goal_y_.sample(episode), kGoalHeight};
    engine_.state->place_prop(env, kGoalProp, goal, kUprightQuat);
  }

  // --- success ---

  void evaluate(Range envs) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      publish_velocity(env);
      engine_.success[env] = goal_distance(env) < params_.GOAL_RADIUS ? 1 : 0;
      reward_dict_.publish(env);
    }
  }

  // --- reward ---

  void dense_reward(Range envs, FloatRows out) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      InterceptReward reward{.ball = ball(env),
                             .goal = goal(env),
                             .tcp = tcp_pos(env),
                             .reached = reached_[env] != 0,
                             .success = engine_.success[env] != 0,
                             .ball_radius = params_.ball.BALL_RADIUS,
                             .penalty = params_.ball.penalty(engine_, env)};
      *out.row(env) = static_cast<float>(reward_dict_.compute(env, reward));
      reached_[env] = reward.reached ? 1 : 0;
    }
  }

  // --- observation ---

  void observe(Range envs, FloatRows out) override { write_state(*this, envs, out); }

  template <class Visitor>
  void state_row(Visitor& row, int env) const {
    row.field("goal_pos", 3, "m", "centre of the target", [&] { return goal(env); });
    launch_fields(row, env);
    motion_fields(row, env);
    row.field("ball_to_goal_pos", 3, "m", "", [&] { return Vector(goal(env) - ball(env)); });
  }

  // --- expert ---

  const Expert& expert() const override { return expert_; }

 private:
  Vector goal(int env) const { return prop_pos(env, kGoalProp); }
  double goal_distance(int env) const { return (ball(env) - goal(env)).head<2>().norm(); }

  Params params_;
  RealVariable goal_y_;
  Column<std::uint8_t> reached_;  // latched: the hand was once behind the ball
  DeflectExpert expert_;
};

}  // namespace

double InterceptReward::compute() {
  const Vector hit = ball + (ball_radius + kHitGap) * (ball - goal).normalized();
  tcp_to_hit_pose_dist = (hit - tcp).norm();
  reached = reached || tcp_to_hit_pose_dist < kReachedDistance;
  reaching = 1 - real::tanh(2 * tcp_to_hit_pose_dist);
  place = 1 - real::tanh((ball - goal).head<2>().norm());
  if (success) return kSuccessReward;
  return (reached ? 5 * place : 2 * reaching) - penalty;
}

constexpr auto kRows = rows_of(kVariants);

const Family kIntercept = {
    .name = "Intercept",
    .memory_type = "Spatial",
    .instruction =
        "Intercept the rolling ball by moving to its path and deflecting it toward the target.",
    .tasks = kRows,
    .make = make_variant<Intercept, kVariants>,
    .expectations = {.min_reward = 0,
                     .max_reward = 0.1501,
                     .moves_untouched = true,
                     .settles = false},
    .memory = {.no_counterfactuals = "nothing is hidden"}};

}  // namespace engram::tasks
