#include "tasks/intercept/ball_game.h"

#include <algorithm>
#include <cmath>

#include "mjcf/ball.h"
#include "tasks/common/phase_budget.h"
#include "tasks/common/poses.h"

namespace engram::tasks {
namespace {

// The farthest and slowest ball has so far to roll until a hand can reach it.
constexpr double kWayIntoReach = 0.39;  // m
constexpr double kRolling = 5 / 7.0;    // of the launch's speed is left once it rolls
constexpr double kControlStep = 0.05;   // s
constexpr int kTimeToAct = 15;          // control steps that a catch takes
constexpr double kMaxDrift = 0.05;      // m/s, in x

using Vector = Eigen::Vector3d;

}  // namespace

void BallParams::declare(ConstantBinder& constants) {
  constants.range("VELOCITY_RANGE", VELOCITY_RANGE, {0, 1.5}, "m/s",
                  "speed of the ball's launch, in y; drawn anew in every episode; 0, 0: at rest",
                  {"velocity_y", "of the ball's launch"});
  constants.real("BALL_RADIUS", BALL_RADIUS, {0.012, 0.03}, "m",
                 "of the ball; its mass grows with it, and the hand opens 0.04 m to either side");
  if (smoothness) smoothness->declare(constants);
}

void BallParams::check(int horizon) const {
  if (may_rest()) return;  // waiting brings no ball at rest into reach
  const double steps = kWayIntoReach / (kRolling * VELOCITY_RANGE.low * kControlStep);
  check_horizon(horizon,
                {{"the slowest ball's way into reach at VELOCITY_RANGE[0]",
                  static_cast<int>(std::ceil(steps))}},
                kTimeToAct);
}

BallVariables::BallVariables(RandomVariables list, const BallParams& params)
    : ball_x(list.real("ball_x", {-0.35, -0.05}, "m", "where the ball starts")),
      ball_y(list.real("ball_y", {-0.9, -0.65}, "m", "where the ball starts")),
      velocity_x(list.real("velocity_x", {0, params.rests() ? 0 : kMaxDrift}, "m/s",
                           "of the ball's launch")),
      velocity_y(list.of(params.VELOCITY_RANGE)) {}

BallGame::BallGame(const RegistryEntry& entry, const BallParams& ball, double height,
                   InterceptGoal goal)
    : FamilyBase(entry),
      variables_(RandomVariables(info_.random_variables), ball),
      height_(height),
      annotator_(engine_, goal) {
  info_.oracle_dim = 3;
  info_.oracle_is_real = true;
  info_.phases = {{"manipulation", "always"}};
  declare_sampled_values(*this);
  scene_.props = {mjcf::ball("ball", ball.BALL_RADIUS, {1, 0, 0, 1})};
  scene_.table_ends = true;
}

void BallGame::bind(const Bindings& bindings) {
  FamilyBase::bind(bindings);
  initial_velocity_ = bindings.memory->add<double>("initial_velocity", 3, "m/s");
  reward_dict_.bind(bindings, info_.reward_terms.size());
}

void BallGame::reset(const Episode& episode) {
  const int env = episode.env();
  const State& state = *engine_.state;
  const double pos[3] = {variables_.ball_x.sample(episode), variables_.ball_y.sample(episode),
                         height_};
  state.place_prop(env, kBallProp, pos, kUprightQuat, PropStatus::kAwake);
  double* velocity = initial_velocity_.row(env);
  velocity[0] = variables_.velocity_x.sample(episode);
  velocity[1] = variables_.velocity_y.sample(episode);
  velocity[2] = 0;
  std::copy_n(velocity, 3, state.prop_qvel_of(env, kBallProp));
}

void BallGame::publish_velocity(int env) const {
  RowWriter(engine_.oracle_values.row(env)).add(initial_velocity_.row(env), 3);
}

Vector BallGame::linear_velocity(int env) const {
  return Eigen::Map<const Vector>(engine_.state->prop_qvel_of(env, kBallProp));
}

// Free joints keep the angular velocity in the body's axes.
Vector BallGame::angular_velocity(int env) const {
  const double* q = engine_.state->prop_quat_of(env, kBallProp);
  return Eigen::Quaterniond(q[0], q[1], q[2], q[3]) *
         Eigen::Map<const Vector>(engine_.state->prop_qvel_of(env, kBallProp) + 3);
}

Vector BallGame::initial_velocity(int env) const {
  return Eigen::Map<const Vector>(initial_velocity_.row(env));
}

}  // namespace engram::tasks
