#include "tasks/intercept/ball_launch.h"

#include <algorithm>
#include <cmath>

#include "mjcf/ball.h"
#include "tasks/common/poses.h"

namespace engram::tasks {
namespace {

struct Interval {
  double low, high;
};
constexpr Interval kStartX = {-0.35, -0.05};  // m
constexpr Interval kStartY = {-0.9, -0.65};
constexpr Interval kDrift = {0, 0.05};  // m/s

// The farthest and slowest ball has so far to roll until a hand can reach it.
constexpr double kWayIntoReach = 0.39;  // m
constexpr double kRolling = 5 / 7.0;    // of the launch's speed is left once it rolls
constexpr double kControlStep = 0.05;   // s
constexpr int kTimeToAct = 15;          // control steps that a catch takes

using Vector = Eigen::Vector3d;

}  // namespace

void BallParams::constants(Changes& list) {
  list.real_range("VELOCITY_RANGE", VELOCITY_RANGE.low, VELOCITY_RANGE.high, {0.1, 1.5}, "m/s",
                  "speed of the ball's launch, in y; drawn anew in every episode");
  list.real("BALL_RADIUS", BALL_RADIUS, {0.012, 0.03}, "m",
            "of the ball; its mass grows with it, and the hand opens 0.04 m to either side");
  smoothness.constants(list);
}

void BallParams::check(int horizon) const {
  const double steps = kWayIntoReach / (kRolling * VELOCITY_RANGE.low * kControlStep);
  check_time(horizon,
             {{"the slowest ball's way into reach at VELOCITY_RANGE[0]",
               static_cast<int>(std::ceil(steps))}},
             kTimeToAct);
}

mjcf::Prop launched_ball(double radius) { return mjcf::ball("ball", radius, {1, 0, 0, 1}); }

void describe_launch(VelocityRange speed, TaskInfo& info) {
  info.termination = Termination::kNever;
  info.oracle_dim = 3;
  info.oracle_is_real = true;
  info.random_variables = {
      {"ball_x", 1, false, kStartX.low, kStartX.high, "m", "where the ball starts"},
      {"ball_y", 1, false, kStartY.low, kStartY.high, "m", "where the ball starts"},
      {"velocity_x", 1, false, kDrift.low, kDrift.high, "m/s", "of the ball's launch"},
      {"velocity_y", 1, false, speed.low, speed.high, "m/s", "of the ball's launch", false,
       "VELOCITY_RANGE"},
  };
  info.phases = {{"manipulation", "always"}};
}

double haste_penalty(const Bindings& engine, int env, const SmoothnessParams& params) {
  const bool free =
      params.ACTION_L2_COEF == 0 && params.ACTION_DELTA_L2_COEF == 0 && params.QVEL_L2_COEF == 0;
  return free ? 0.0 : smoothness(measure_haste(engine, env), params).penalty;
}

void BallLaunch::bind(const Bindings& bindings) {
  engine_ = bindings;
  initial_velocity_ = bindings.memory->add<double>("initial_velocity", 3, "m/s");
}

void BallLaunch::reset(const Episode& episode) const {
  const int env = episode.env();
  const State& state = *engine_.state;
  const double pos[3] = {episode.real(kBallX, kStartX.low, kStartX.high),
                         episode.real(kBallY, kStartY.low, kStartY.high), height_};
  state.place_prop(env, kBallProp, pos, kUprightQuat, PropStatus::kAwake);
  double* velocity = initial_velocity_.row(env);
  velocity[0] = episode.real(kVelocityX, kDrift.low, kDrift.high);
  velocity[1] = episode.real(kVelocityY, speed_.low, speed_.high);
  velocity[2] = 0;
  std::copy_n(velocity, 3, state.prop_qvel_of(env, kBallProp));
}

void BallLaunch::tell_velocity(int env) const {
  RowWriter(engine_.oracle_values.row(env)).add(initial_velocity_.row(env), 3);
}

Vector BallLaunch::ball(int env) const {
  return Eigen::Map<const Vector>(engine_.state->prop_pos_of(env, kBallProp));
}

Vector BallLaunch::linear_velocity(int env) const {
  return Eigen::Map<const Vector>(engine_.state->prop_qvel_of(env, kBallProp));
}

// Free joints keep the angular velocity in the body's axes.
Vector BallLaunch::angular_velocity(int env) const {
  const double* q = engine_.state->prop_quat_of(env, kBallProp);
  return Eigen::Quaterniond(q[0], q[1], q[2], q[3]) *
         Eigen::Map<const Vector>(engine_.state->prop_qvel_of(env, kBallProp) + 3);
}

Vector BallLaunch::initial_velocity(int env) const {
  return Eigen::Map<const Vector>(initial_velocity_.row(env));
}

Vector BallLaunch::tcp(int env) const {
  return Eigen::Map<const Vector>(engine_.state->tcp_pos.row(env));
}

void BallLaunch::add_pose(int env, RowWriter& out) const {
  out.add_pose(engine_.state->prop_pos_of(env, kBallProp),
               engine_.state->prop_quat_of(env, kBallProp));
}

}  // namespace engram::tasks
