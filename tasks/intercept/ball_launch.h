// Ball that rolls past the robot in Intercept and InterceptGrab
// (docs/tasks/intercept.md).
#pragma once

#include "core/env/task.h"
#include "mjcf/prop.h"
#include "tasks/common/changes.h"
#include "tasks/common/smoothness.h"
#include "tasks/common/state_row.h"

namespace engram::tasks {

inline constexpr double BALL_RADIUS = 0.02;  // m, unless a user changes it

struct VelocityRange {
  double low = 0;  // m/s
  double high = 0;

  Constant constant() const { return ConstantList{low, high}; }
};

// Parameters that both families have.
struct BallParams {
  VelocityRange VELOCITY_RANGE;
  double BALL_RADIUS = tasks::BALL_RADIUS;  // m
  SmoothnessParams smoothness = {};         // in the original nothing comes of it

  void constants(Changes& list);
  // Throws Error unless even the slowest ball comes within reach in time.
  void check(int horizon) const;
};

// The ball is the scene's first prop.
inline constexpr int kBallProp = 0;
mjcf::Prop launched_ball(double radius);

// A task's first draws are those of the launch.
enum BallDraw { kBallX, kBallY, kVelocityX, kVelocityY, kBallDraws };

// Fills in what both families say of themselves, the draws of the launch included.
void describe_launch(VelocityRange speed, TaskInfo& info);

// The penalty on haste; nothing is computed where it weighs nothing.
double haste_penalty(const Bindings& engine, int env, const SmoothnessParams& params);

class BallLaunch {
 public:
  // `height`: of the ball's centre when it is let go, m.
  BallLaunch(VelocityRange speed, double height) : speed_(speed), height_(height) {}

  void bind(const Bindings& bindings);
  // Samples a launch and lets the ball go.
  void reset(const Episode& episode) const;
  // Shows the initial velocity as oracle_info.
  void tell_velocity(int env) const;

  Eigen::Vector3d ball(int env) const;
  Eigen::Vector3d linear_velocity(int env) const;   // m/s, world
  Eigen::Vector3d angular_velocity(int env) const;  // rad/s, world
  Eigen::Vector3d initial_velocity(int env) const;  // m/s
  Eigen::Vector3d tcp(int env) const;

  void add_pose(int env, RowWriter& out) const;

 private:
  VelocityRange speed_;
  double height_;
  Bindings engine_;
  Column<double> initial_velocity_;  // (3) m/s
};

}  // namespace engram::tasks
