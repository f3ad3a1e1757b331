#include "tasks/intercept/deflect.h"

#include <algorithm>
#include <array>

#include "core/math/real_functions.h"
#include "mjcf/target_disc.h"
#include "tasks/common/family_base.h"
#include "tasks/common/poses.h"
#include "tasks/common/reward_dict.h"
#include "tasks/common/variant.h"
#include "tasks/intercept/annotator.h"
#include "tasks/intercept/ball_launch.h"
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

template <class Visitor>
void list_terms(Visitor& row, const InterceptRewardTerms& terms) {
  row.term("reaching_reward", "", terms.reaching);
  row.term("reached_status", "", terms.reached);
  row.term("place_reward", "", terms.place);
  row.term("tcp_to_hit_pose_dist", "m", terms.tcp_to_hit_pose_dist);
}

class Intercept final : public FamilyBase {
 public:
  Intercept(const RegistryEntry& entry, const Params& params)
      : FamilyBase(entry),
        params_(params),
        launch_({RandomVariables(info_.random_variables), params.ball},
                kStartRadii * params.ball.BALL_RADIUS),
        goal_y_(RandomVariables(info_.random_variables)
                    .real("goal_y", {-kGoalSpan, kGoalSpan}, "m", "where the target lies")),
        expert_({.engine = engine_,
                 .goal_prop = kGoalProp,
                 .ball = params.ball,
                 .goal_radius = params.GOAL_RADIUS}),
        annotator_(engine_, InterceptGoal::kDeflect) {
    describe_launch(info_);
    info_.success_reward = kSuccessReward;
    info_.reward_terms = reward_terms_of([](auto& row) { list_terms(row, {}); });
    declare_state(*this);
    declare_sampled_values(*this);
    scene_.props = {launched_ball(params.ball.BALL_RADIUS),
                    mjcf::target_disc("goal_region", params.GOAL_RADIUS, kTargetRed)};
    scene_.table_ends = true;
  }

  void bind(const Bindings& bindings) override {
    FamilyBase::bind(bindings);
    launch_.bind(bindings);
    reward_dict_.bind(bindings, info_.reward_terms.size());
    reached_ = bindings.memory->add<std::uint8_t>("reached");
  }

  // --- sampling ---

  void reset(const Episode& episode) override {
    const int env = episode.env();
    launch_.reset(episode);
    const double goal[3] = {launch_.ball(env).x() + kGoalAhead, goal_y_.sample(episode),
                            kGoalHeight};
    engine_.state->place_prop(env, kGoalProp, goal, kUprightQuat);
  }

  // --- phases: none, and nothing is hidden at any time ---

  void advance(Range /*envs*/) override {}
  int cue_end(int /*env*/) const override { return 0; }
  void sampled_values(int env, float* out) const override { write_sampled_values(*this, env, out); }
  template <class Visitor>
  void sampled_row(Visitor& row, int env) const {
    row.field("initial_velocity", 3, "m/s", "of the ball",
              [&] { return launch_.initial_velocity(env); });
  }

  // --- success ---

  void evaluate(Range envs) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      launch_.publish_velocity(env);
      engine_.success[env] = goal_distance(env) < params_.GOAL_RADIUS ? 1 : 0;
      reward_dict_.publish(env);
    }
  }

  // --- reward ---

  void dense_reward(Range envs, FloatRows out) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      const InterceptRewardTerms terms =
          intercept_reward({launch_.ball(env), goal(env), launch_.tcp(env), reached_[env] != 0,
                            engine_.success[env] != 0, params_.ball.BALL_RADIUS,
                            params_.ball.penalty(engine_, env)});
      reached_[env] = terms.reached ? 1 : 0;
      reward_dict_.note(env, [&](auto& row) { list_terms(row, terms); });
      *out.row(env) = static_cast<float>(terms.reward);
    }
  }

  // --- observation ---

  void observe(Range envs, FloatRows out) override { write_state(*this, envs, out); }

  template <class Visitor>
  void state_row(Visitor& row, int env) const {
    row.field("goal_pos", 3, "m", "centre of the target", [&] { return goal(env); });
    row.field("ball_pose", 7, "m", "position, quaternion (w, x, y, z)",
              [&](RowWriter& out) { launch_.add_pose(env, out); });
    row.field("oracle_info", 3, "m/s", "initial velocity of the ball",
              [&] { return launch_.initial_velocity(env); });
    row.field("ball_linear_vel", 3, "m/s", "", [&] { return launch_.linear_velocity(env); });
    row.field("ball_angular_vel", 3, "rad/s", "about the world's axes",
              [&] { return launch_.angular_velocity(env); });
    row.field("tcp_to_ball_pos", 3, "m", "",
              [&] { return Vector(launch_.ball(env) - launch_.tcp(env)); });
    row.field("ball_to_goal_pos", 3, "m", "",
              [&] { return Vector(goal(env) - launch_.ball(env)); });
  }

  // --- expert ---

  const Expert& expert() const override { return expert_; }
  const Annotator* annotator() const override { return &annotator_; }

 private:
  Vector goal(int env) const {
    return Eigen::Map<const Vector>(engine_.state->prop_pos_of(env, kGoalProp));
  }
  double goal_distance(int env) const { return (launch_.ball(env) - goal(env)).head<2>().norm(); }

  Params params_;
  BallLaunch launch_;
  RealVariable goal_y_;
  RewardDict reward_dict_;
  Column<std::uint8_t> reached_;  // latched: the hand was once behind the ball
  DeflectExpert expert_;
  InterceptAnnotator annotator_;
};

}  // namespace

InterceptRewardTerms intercept_reward(const InterceptRewardInputs& in) {
  InterceptRewardTerms terms;
  const Vector hit = in.ball + (in.ball_radius + kHitGap) * (in.ball - in.goal).normalized();
  terms.tcp_to_hit_pose_dist = (hit - in.tcp).norm();
  terms.reached = in.reached || terms.tcp_to_hit_pose_dist < kReachedDistance;
  terms.reaching = 1 - real::tanh(2 * terms.tcp_to_hit_pose_dist);
  terms.place = 1 - real::tanh((in.ball - in.goal).head<2>().norm());
  terms.reward = (terms.reached ? 5 * terms.place : 2 * terms.reaching) - in.penalty;
  if (in.success) terms.reward = kSuccessReward;
  return terms;
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
