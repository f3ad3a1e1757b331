// Ball that rolls past the robot in Intercept and InterceptGrab
// (docs/tasks/intercept.md).
#pragma once

#include <limits>
#include <optional>

#include "core/task/task.h"
#include "mjcf/prop.h"
#include "tasks/common/action_cost.h"
#include "tasks/common/constant_binder.h"
#include "tasks/common/random_variables.h"
#include "tasks/common/state_row.h"
#include "tasks/registry.h"

namespace engram::tasks {

inline constexpr double BALL_RADIUS = 0.02;  // m, unless a user changes it

// Parameters that both families have.
struct BallParams {
  SampledRange<double> VELOCITY_RANGE;      // m/s
  double BALL_RADIUS = tasks::BALL_RADIUS;  // m
  // In the original nothing comes of it. None: rewards know no action cost.
  std::optional<SmoothnessParams> smoothness = SmoothnessParams{};
  // Speed up to which the expert's hand runs along with the ball, m/s; it blocks faster ones.
  double fastest_followed = std::numeric_limits<double>::infinity();

  bool stops_first() const { return fastest_followed < std::numeric_limits<double>::infinity(); }
  // A ball that is not launched does not drift either.
  bool rests() const { return VELOCITY_RANGE.high == 0; }
  // Some balls may never come within reach.
  bool may_rest() const { return VELOCITY_RANGE.low == 0; }

  // On large and abrupt actions.
  double penalty(const Bindings& engine, int env) const {
    return smoothness ? smoothness_penalty(engine, env, *smoothness) : 0.0;
  }

  void declare(ConstantBinder& constants);
  // Throws Error unless even the slowest ball that is launched comes within reach in time.
  void check(int horizon) const;
};

// The ball is the scene's first prop.
inline constexpr int kBallProp = 0;
mjcf::Prop launched_ball(double radius);

// Random variables of a launch.
struct BallVariables {
  BallVariables(RandomVariables list, const BallParams& params);

  RealVariable ball_x;
  RealVariable ball_y;
  RealVariable velocity_x;
  RealVariable velocity_y;
};

// Parameters of both families' RL tasks. A hand whose joints turn by 0.1 rad at most runs along
// with slow balls alone.
constexpr BallParams rl_ball(double slowest, double fastest) {
  return {
      .VELOCITY_RANGE = {slowest, fastest}, .smoothness = std::nullopt, .fastest_followed = 0.34};
}

// Fills in the part of TaskInfo that both families share.
void describe_launch(TaskInfo& info);

class BallLaunch {
 public:
  // `height`: of the ball's centre when it is let go, m.
  BallLaunch(const BallVariables& variables, double height)
      : variables_(variables), height_(height) {}

  void bind(const Bindings& bindings);
  // Samples a launch and lets the ball go.
  void reset(const Episode& episode) const;
  // Shows the initial velocity as oracle_info.
  void publish_velocity(int env) const;

  Eigen::Vector3d ball(int env) const;
  Eigen::Vector3d linear_velocity(int env) const;   // m/s, world
  Eigen::Vector3d angular_velocity(int env) const;  // rad/s, world
  Eigen::Vector3d initial_velocity(int env) const;  // m/s
  Eigen::Vector3d tcp(int env) const;

  void add_pose(int env, RowWriter& out) const;

 private:
  BallVariables variables_;
  double height_;
  Bindings engine_;
  Column<double> initial_velocity_;  // (3) m/s
};

}  // namespace engram::tasks
