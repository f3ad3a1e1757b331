// Rotations from angles and back, with the same bits on every processor.
#pragma once

#include <Eigen/Geometry>
#include <cmath>

#include "core/math/real_functions.h"

namespace engram {

// Rotation by an angle (rad) about an axis of length 1.
inline Eigen::Quaterniond turn_about(const Eigen::Vector3d& axis, double angle) {
  const Eigen::Vector3d vector = real::sin(angle / 2) * axis;
  return {real::cos(angle / 2), vector.x(), vector.y(), vector.z()};
}

// The angle between two orientations, 0 to pi.
inline double angle_between(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b) {
  const Eigen::Quaterniond turn = a * b.conjugate();
  return 2 * real::atan2(turn.vec().norm(), std::abs(turn.w()));
}

}  // namespace engram
