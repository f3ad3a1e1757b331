// Position servo of the TCP, for experts: pd_ee_delta_pose actions towards a pose.
#pragma once

#include <Eigen/Dense>

#include "core/sim/state.h"

namespace engram {
class Arm;  // core/robot/arm.h
}

namespace engram::tasks {

// TCP orientation of the start pose: pointing straight down, fingers open along y.
inline const Eigen::Quaterniond kToolDown(0, 1, 0, 0);

inline constexpr double kRobotBaseX = -0.615;  // m: of the robot's base axis; its y is 0

inline constexpr double kGripperOpen = 1.0;     // 0.04 m per finger
inline constexpr double kGripperClosed = -0.6;  // exactly closed, no squeeze

inline constexpr double kGripperSqueezing = -1.0;  // closed, and pressing on what is in between

// Fraction of a commanded change that the drives cover in one control step.
inline constexpr double kStepResponse = 0.38;

// Writes an action that brings the TCP towards a pose, as fast as the drives allow and without
// overshoot. `action` has 7 components; rotations have the original benchmark's sign.
void servo_tcp(const State& state, int env, const Eigen::Vector3d& goal,
               const Eigen::Quaterniond& orientation, double gripper, float* action);

// Turns the tool and moves it by a given displacement, `command`, m.
void displace_tcp(const State& state, int env, const Eigen::Vector3d& command,
                  const Eigen::Quaterniond& orientation, double gripper, float* action);

// Writes an action that brings the TCP towards a point as fast as joint steps of 0.1 rad allow. The
// tool turns and tilts as the arm finds it easiest, which is nearly twice as fast as to keep its
// orientation.
void reach_point(const State& state, const Arm& arm, int env, const Eigen::Vector3d& goal,
                 double gripper, float* action);

// Writes an action that brings the TCP to a pose by an even motion of all joints, at the speed that
// pd_joint_delta_pos allows: the way is not straight, but quick.
void swing_tcp(const State& state, const Arm& arm, int env, const Eigen::Vector3d& goal,
               const Eigen::Quaterniond& orientation, double gripper, float* action);

// Limits the translation of an action the more, the lower the TCP is, down to a quarter of full
// speed at `height`: a hand that changes its height fast sways by a centimetre.
void limit_speed_near(const State& state, int env, double height, float* action);

// m/s, from the speeds of the joints.
Eigen::Vector3d tcp_velocity(const State& state, const Arm& arm, int env);

// kToolDown turned about the vertical by `yaw`, counter-clockwise from above.
Eigen::Quaterniond tool_down(double yaw);
// Yaw of a TCP that points more or less down, -pi to pi.
double tcp_yaw(const State& state, int env);

// Outward tilt of the tool by distance from the base's axis.
struct Tilt {
  double reach = 0.74;     // m: from there on
  double per_metre = 4.0;  // rad/m
  double most = 0.4;       // rad
  double fold = 0;         // m: nearer than that it tilts inwards likewise
};

// `orientation`, tilted outwards as far as a point demands that a vertical tool cannot reach.
Eigen::Quaterniond tilt_outwards(const Eigen::Quaterniond& orientation,
                                 const Eigen::Vector3d& point, const Tilt& tilt = {});

// Writes the action that lets the robot rest where it is.
void hold_tcp(double gripper, float* action);

// Waypoint of a vertical approach: `clearance` above it until the TCP is nearly overhead.
Eigen::Vector3d approach_from_above(const State& state, int env, const Eigen::Vector3d& goal,
                                    double clearance);

// Waypoint of a quicker approach: the TCP keeps above a funnel around the goal, which is `radius`
// wide at its height and rises by `slope` beyond that.
Eigen::Vector3d approach_by_funnel(const State& state, int env, const Eigen::Vector3d& goal,
                                   double radius, double slope);

// Approach by a narrow funnel, never above `travel_height` unless the goal is.
Eigen::Vector3d descend(const State& state, int env, const Eigen::Vector3d& goal,
                        double travel_height);

}  // namespace engram::tasks
