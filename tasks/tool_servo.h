// Moves the tool for oracles: pd_ee_delta_pose actions from where the TCP should be.
#pragma once

#include <Eigen/Dense>

#include "core/state.h"

namespace engram::tasks {

// TCP orientation of the start pose: pointing straight down, fingers open along y (common 1.5).
inline const Eigen::Quaterniond kToolDown(0, 1, 0, 0);

inline constexpr double kGripperOpen = 1.0;     // 0.04 m per finger
inline constexpr double kGripperClosed = -0.6;  // exactly closed, no squeeze

// Fraction of a commanded change that the drives cover in one control step (common 2.1).
inline constexpr double kStepResponse = 0.38;

// Writes an action that brings the TCP towards a pose, as fast as the drives allow and without
// overshoot. `action` has 7 components; upstream's rotation sign.
void servo_tool(const State& state, int env, const Eigen::Vector3d& goal,
                const Eigen::Quaterniond& orientation, double gripper, float* action);

// The action that lets the robot rest where it is.
void hold_tool(double gripper, float* action);

// A way down onto a point: the tool keeps `clearance` above it until it is nearly overhead.
Eigen::Vector3d approach_from_above(const State& state, int env, const Eigen::Vector3d& goal,
                                    double clearance);

// The same along a slope: the tool comes down to the point while it gets there, and rises to
// `travel_height` where the point is far.
Eigen::Vector3d glide_down(const State& state, int env, const Eigen::Vector3d& goal,
                           double travel_height);

}  // namespace engram::tasks
