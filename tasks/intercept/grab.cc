#include "tasks/intercept/grab.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/math/real_functions.h"
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
  GrabBonuses bonuses = {};

  void declare(ConstantBinder& constants) { ball.declare(constants); }
  void check(int horizon) const { ball.check(horizon); }
};

constexpr GrabBonuses kRlBonuses = {.attempt = 45, .grasp = 100};

constexpr std::array<Params, 6> kVariants = {{
    {{"InterceptGrabFast-VLA-v0", 60, Split::kShort, 0.70}, {{0.75, 1.0}}},
    {{"InterceptGrabMedium-VLA-v0", 60, Split::kShort, 0.80}, {{0.5, 0.75}}},
    {{"InterceptGrabSlow-VLA-v0", 60, Split::kShort, 0.90}, {{0.25, 0.5}}},
    {{"InterceptGrabSlow-v0", 90, Split::kRl}, rl_ball(0.25, 0.5), kRlBonuses},
    {{"InterceptGrabMedium-v0", 90, Split::kRl}, rl_ball(0.5, 0.75), kRlBonuses},
    {{"InterceptGrabFast-v0", 90, Split::kRl}, rl_ball(0.75, 1.0), kRlBonuses},
}};

constexpr double kSuccessReward = 300;

class InterceptGrab final : public BallGame {
 public:
  InterceptGrab(const RegistryEntry& entry, const Params& params)
      : BallGame(entry, params.ball, params.ball.BALL_RADIUS, InterceptGoal::kGrab),
        params_(params),
        expert_(engine_, params.ball) {
    info_.success_reward = kSuccessReward;
    info_.reward_terms = reward_terms_of(GrabReward{});
    declare_state(*this);
  }

  void bind(const Bindings& bindings) override {
    BallGame::bind(bindings);
    is_ball_grasped_ = bindings.outputs->add<std::uint8_t>("is_ball_grasped");
    is_robot_static_ = bindings.outputs->add<std::uint8_t>("is_robot_static");
  }

  // --- success ---

  void evaluate(Range envs) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      const State& state = *engine_.state;
      publish_velocity(env);
      is_ball_grasped_[env] = is_grasping(state, env, kBallProp) ? 1 : 0;
      is_robot_static_[env] = robot_is_static(state, env) ? 1 : 0;
      engine_.success[env] = is_ball_grasped_[env] & is_robot_static_[env];
      reward_dict_.publish(env);
    }
  }

  // --- reward ---

  void dense_reward(Range envs, FloatRows out) override {
    reward_dict_.write(envs, out, [&](int env) {
      return GrabReward{.ball = ball(env),
                        .tcp = tcp_pos(env),
                        .gripper_width = gripper_width(env),
                        .grasped = is_ball_grasped_[env] != 0,
                        .success = engine_.success[env] != 0,
                        .ball_radius = params_.ball.BALL_RADIUS,
                        .penalty = params_.ball.penalty(engine_, env),
                        .bonuses = params_.bonuses,
                        .ball_speed = linear_velocity(env).norm(),
                        .ball_spin = angular_velocity(env).norm(),
                        .robot_static = is_robot_static_[env] != 0};
    });
  }

  // --- observation ---

  void observe(Range envs, FloatRows out) override { write_state(*this, envs, out); }

  template <class Visitor>
  void state_row(Visitor& row, int env) const {
    launch_fields(row, env);
    row.field("is_ball_grasped", 1, "", "", [&] { return is_ball_grasped_[env]; });
    motion_fields(row, env);
    row.field("gripper_width", 1, "m", "sum of both finger positions",
              [&] { return gripper_width(env); });
    row.field("relative_velocity", 3, "m/s", "of the ball, as seen from the TCP",
              [&] { return Vector(linear_velocity(env) - tcp_velocity(env)); });
  }

  // --- expert ---

  const Expert& expert() const override { return expert_; }

 private:
  Vector tcp_velocity(int env) const {
    ArmJacobian jacobian;
    engine_.arm->forward(engine_.state->qpos.row(env), jacobian);
    return jacobian.topRows<3>() * Eigen::Map<const ArmVector>(engine_.state->qvel.row(env));
  }

  Params params_;
  Column<std::uint8_t> is_ball_grasped_;
  Column<std::uint8_t> is_robot_static_;
  GrabExpert expert_;
};

}  // namespace

double GrabReward::compute() {
  offset = (ball - tcp).cwiseAbs();
  const double width = gripper_width;
  const double diameter = 2 * ball_radius;
  distance = offset.norm();
  in_gripper = offset.x() <= 0.04 && offset.y() <= 0.04 && offset.z() <= 0.03 && distance <= 0.04 &&
               width >= diameter;
  very_close = distance <= 0.025;
  ball_stillness = 1 - real::tanh(10 * ball_speed + ball_spin);
  if (success) return kSuccessReward;

  double reward = 10 * (1 - real::tanh(3 * distance));
  if (in_gripper) {
    reward += 10 + 90 * real::exp(-5 * std::max(std::abs(width - diameter) - 0.02, 0.0));
    if (width <= diameter + 0.02) reward += bonuses.attempt;
  }
  if (very_close) reward += 30 * (1 - distance / 0.06);
  if (grasped) reward += bonuses.grasp;
  return reward - penalty;
}

constexpr auto kRows = rows_of(kVariants);

const Family kInterceptGrab = {.name = "InterceptGrab",
                               .memory_type = "Spatial",
                               .instruction = "Intercept the rolling ball and grasp it to stop it.",
                               .tasks = kRows,
                               .make = make_variant<InterceptGrab, kVariants>,
                               .expectations = {.min_reward = 0,
                                                .max_reward = 1.4334,
                                                .moves_untouched = true,
                                                .settles = false},
                               .memory = {.no_counterfactuals = "nothing is hidden"}};

}  // namespace engram::tasks
