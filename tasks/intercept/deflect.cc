#include "tasks/intercept/deflect.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "mjcf/scene.h"
#include "mjcf/target_disc.h"
#include "tasks/intercept/ball_catcher.h"
#include "tasks/intercept/ball_launch.h"
#include "tasks/parts/reward_dict.h"
#include "tasks/parts/task_info.h"
#include "tasks/parts/tool_servo.h"
#include "tasks/parts/variant.h"

namespace engram::tasks {
namespace {

using Vector = Eigen::Vector3d;

// --- parameters (section 1) ---

struct Params {
  std::string_view id;
  VelocityRange VELOCITY_RANGE;  // m/s
};

constexpr std::array<Params, 3> kVariants = {{
    {"InterceptSlow-VLA-v0", {0.25, 0.5}},
    {"InterceptMedium-VLA-v0", {0.5, 0.75}},
    {"InterceptFast-VLA-v0", {0.75, 1.0}},
}};

constexpr double GOAL_RADIUS = 0.1;               // m
constexpr double kStartHeight = 2 * BALL_RADIUS;  // m: it falls onto the table
constexpr double kGoalAhead = 0.2;                // m, in x, from the ball's start
constexpr double kGoalSpan = 0.2;                 // m, in y, to either side
constexpr double kGoalHeight = 0.001;             // m
constexpr double kHitDistance = 0.02 + 0.05;      // m: behind the ball, as seen from the goal
constexpr double kReachedDistance = 0.04;         // m
constexpr double kSuccessReward = 30;
constexpr mjcf::Rgba kTargetRed = {194 / 255.0, 19 / 255.0, 22 / 255.0, 1};
constexpr double kUpright[4] = {1, 0, 0, 0};

constexpr int kGoalProp = 1;
constexpr int kGoalY = kBallDraws;

std::vector<Draw> draws(const Params& params) {
  std::vector<Draw> result = ball_draws(params.VELOCITY_RANGE);
  result.push_back({"goal_y", 1, false, -kGoalSpan, kGoalSpan, "m", "where the target lies"});
  return result;
}

ConstantTable constants(const Params& params) {
  return {{"BALL_RADIUS", BALL_RADIUS}, {"GOAL_RADIUS", GOAL_RADIUS},
          {"ACTION_L2_COEF", 0.0},      {"ACTION_DELTA_L2_COEF", 0.0},
          {"QVEL_L2_COEF", 0.0},        {"VELOCITY_RANGE", params.VELOCITY_RANGE.constant()}};
}

std::vector<Field> state_fields() {
  constexpr DType kFloat = DType::kFloat32;
  return {{"goal_pos", 3, kFloat, "m", "centre of the target"},
          {"ball_pose", 7, kFloat, "m", "position, quaternion (w, x, y, z)"},
          {"oracle_info", 3, kFloat, "m/s", "initial velocity of the ball"},
          {"ball_linear_vel", 3, kFloat, "m/s", ""},
          {"ball_angular_vel", 3, kFloat, "rad/s", "about the world's axes"},
          {"tcp_to_ball_pos", 3, kFloat, "m", ""},
          {"ball_to_goal_pos", 3, kFloat, "m", ""}};
}

constexpr int kRewardTerms = 4;

class Intercept final : public Task {
 public:
  Intercept(const RegistryEntry& entry, const Params& params)
      : launch_(params.VELOCITY_RANGE, kStartHeight) {
    info_ = describe(entry);
    info_.termination = Termination::kNever;
    info_.success_reward = kSuccessReward;
    info_.oracle_dim = 3;
    info_.oracle_is_real = true;
    info_.draws = draws(params);
    info_.constants = constants(params);
    info_.reward_terms = {"reaching_reward", "reached_status", "place_reward",
                          "tcp_to_hit_pose_dist"};
    info_.phases = {{"manipulation", "always"}};
    info_.state_fields = state_fields();
    scene_.props = {launched_ball(), mjcf::target_disc("goal_region", GOAL_RADIUS, kTargetRed)};
    scene_.table_ends = true;
  }

  const TaskInfo& info() const override { return info_; }
  SceneSource scene() const override { return scene_source(scene_); }
  std::string document() const override { return mjcf::compose(scene_, mjcf::Detail::kFull); }

  void bind(const Bindings& bindings) override {
    engine_ = bindings;
    launch_.bind(bindings);
    reward_dict_.bind(bindings, kRewardTerms);
    reached_ = bindings.memory->add<std::uint8_t>("reached");
  }

  // Nothing is hidden at any time.
  int cue_end(int /*env*/) const override { return 0; }

  // --- sampling (section 1.2) ---

  void reset(const Episode& episode) override {
    const int env = episode.env();
    launch_.reset(episode);
    const double goal[3] = {launch_.ball(env).x() + kGoalAhead,
                            episode.real(kGoalY, -kGoalSpan, kGoalSpan), kGoalHeight};
    engine_.state->place_prop(env, kGoalProp, goal, kUpright);
  }

  void advance(Range /*envs*/) override {}

  // --- success and reward (sections 1.4 and 1.5) ---

  void evaluate(Range envs) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      launch_.tell_velocity(env);
      engine_.success[env] = goal_distance(env) < GOAL_RADIUS ? 1 : 0;
      reward_dict_.publish(env);
    }
  }

  void dense_reward(Range envs, FloatRows out) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      const InterceptRewardTerms terms =
          intercept_reward({launch_.ball(env), goal(env), launch_.tcp(env), reached_[env] != 0,
                            engine_.success[env] != 0});
      reached_[env] = terms.reached ? 1 : 0;
      reward_dict_.note<kRewardTerms>(env, {terms.reaching, terms.reached ? 1.0 : 0.0, terms.place,
                                            terms.tcp_to_hit_pose_dist});
      *out.row(env) = static_cast<float>(terms.reward);
    }
  }

  // --- observation (section 1.4) ---

  void observe(Range envs, FloatRows out) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      RowWriter row(out.row(env));
      row.add(goal(env));
      launch_.observe_pose(env, row);
      row.add(launch_.initial_velocity(env));
      row.add(launch_.linear_velocity(env));
      row.add(launch_.angular_velocity(env));
      row.add(launch_.ball(env) - launch_.tcp(env));
      row.add(goal(env) - launch_.ball(env));
    }
  }

  // --- oracle (section 1.6): catch the ball and carry it to the target ---

  void act(Range envs, bool /*blind*/, FloatRows actions) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      const State& state = *engine_.state;
      float* action = actions.row(env);
      if (!holds_ball(state, env)) {
        catch_ball(state, env, action);
      } else if (goal_distance(env) < kNearEnough) {
        hold_tool(kGripperSqueezing, action);
      } else {
        const Vector aim(goal(env).x(), goal(env).y(), kCarryHeight);
        servo_tool(state, env, aim, kToolDown, kGripperSqueezing, action);
      }
    }
  }

 private:
  static constexpr double kNearEnough = 0.07;    // m
  static constexpr double kCarryHeight = 0.025;  // m

  Vector goal(int env) const {
    return Eigen::Map<const Vector>(engine_.state->prop_pos_of(env, kGoalProp));
  }
  double goal_distance(int env) const { return (launch_.ball(env) - goal(env)).head<2>().norm(); }

  TaskInfo info_;
  mjcf::Scene scene_;
  Bindings engine_;
  BallLaunch launch_;
  RewardDict reward_dict_;
  Column<std::uint8_t> reached_;  // latched: the hand was once behind the ball
};

}  // namespace

InterceptRewardTerms intercept_reward(const InterceptRewardInputs& in) {
  InterceptRewardTerms terms;
  const Vector hit = in.ball + kHitDistance * (in.ball - in.goal).normalized();
  terms.tcp_to_hit_pose_dist = (hit - in.tcp).norm();
  terms.reached = in.reached || terms.tcp_to_hit_pose_dist < kReachedDistance;
  terms.reaching = 1 - std::tanh(2 * terms.tcp_to_hit_pose_dist);
  terms.place = 1 - std::tanh((in.ball - in.goal).head<2>().norm());
  terms.reward = terms.reached ? 5 * terms.place : 2 * terms.reaching;
  if (in.success) terms.reward = kSuccessReward;
  return terms;
}

std::unique_ptr<Task> make_intercept(const RegistryEntry& entry) {
  return std::make_unique<Intercept>(entry, find_variant(kVariants, entry.id));
}

}  // namespace engram::tasks
