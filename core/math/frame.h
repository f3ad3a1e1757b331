// Rigid frame: position and axes of a body, link or geom.
#pragma once

#include <Eigen/Dense>

namespace engram {

// Position, m, and axes (columns).
struct Frame {
  Eigen::Vector3d pos = Eigen::Vector3d::Zero();
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();
};

// Frame of a position (3) and a unit quaternion (w, x, y, z).
inline Frame make_frame(const double* pos, const double* quat) {
  const Eigen::Quaterniond rotation(quat[0], quat[1], quat[2], quat[3]);
  return {Eigen::Map<const Eigen::Vector3d>(pos), rotation.toRotationMatrix()};
}

}  // namespace engram
