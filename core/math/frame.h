// Rigid frame: position and axes of a body, link or geom.
#pragma once

#include "core/math/eigen_types.h"

namespace engram {

// Position, m, and axes (columns).
struct Frame {
  Vec3 pos = Vec3::Zero();
  Mat3 axes = Mat3::Identity();
};

// Frame of a position (3) and a unit quaternion (w, x, y, z).
inline Frame make_frame(const double* pos, const double* quat) {
  const Quat rotation(quat[0], quat[1], quat[2], quat[3]);
  return {Eigen::Map<const Vec3>(pos), rotation.toRotationMatrix()};
}

}  // namespace engram
