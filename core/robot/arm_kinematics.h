// From the joint angles of the arm to its tool, and from a wanted step of the tool to one of the
// joints; for one or for many side by side.
#pragma once

#include "core/robot/robot_dynamics.h"

namespace engram {
inline namespace ENGRAM_LANES {

template <class V>
struct QuatOf {
  V w, x, y, z;

  ENGRAM_LANES_INLINE Vec3Of<V> turn(const double* v) const {
    const Vec3Of<V> twice = {2.0 * (y * v[2] - z * v[1]), 2.0 * (z * v[0] - x * v[2]),
                             2.0 * (x * v[1] - y * v[0])};
    return {v[0] + w * twice.x + (y * twice.z - z * twice.y),
            v[1] + w * twice.y + (z * twice.x - x * twice.z),
            v[2] + w * twice.z + (x * twice.y - y * twice.x)};
  }
  ENGRAM_LANES_INLINE QuatOf times(const double* q) const {
    return {w * q[0] - x * q[1] - y * q[2] - z * q[3], w * q[1] + x * q[0] + y * q[3] - z * q[2],
            w * q[2] - x * q[3] + y * q[0] + z * q[1], w * q[3] + x * q[2] - y * q[1] + z * q[0]};
  }
  // About its own z axis, by twice the angle that these are of.
  ENGRAM_LANES_INLINE QuatOf turned(V sine, V cosine) const {
    return {w * cosine - z * sine, x * cosine + y * sine, y * cosine - x * sine,
            z * cosine + w * sine};
  }
  ENGRAM_LANES_INLINE Vec3Of<V> z_axis() const {
    return {2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)};
  }
};

template <class V>
struct ToolPose {
  Vec3Of<V> pos;   // m, from the base
  QuatOf<V> quat;  // normalised
};

// Velocity of the TCP, linear, then angular, by a unit of each joint's.
template <class V>
struct ToolJacobian {
  V column[kArmJoints][6];
};

// `jacobian` may be null.
template <class V>
ENGRAM_LANES_INLINE ToolPose<V> arm_forward_kinematics(const RobotModel& chain, const V* q,
                                                       ToolJacobian<V>* jacobian) {
  Vec3Of<V> origin[kArmJoints];
  Vec3Of<V> axis[kArmJoints];
  ToolPose<V> pose = {{}, {spread<V>(1), V{}, V{}, V{}}};
  for (int i = 0; i < kArmJoints; ++i) {
    V sine;
    V cosine;
    sine_cosine(0.5 * q[i], sine, cosine);
    pose.pos = pose.pos + pose.quat.turn(chain.arm[i].offset);
    pose.quat = pose.quat.times(chain.quat[i]).turned(sine, cosine);
    origin[i] = pose.pos;
    if (jacobian != nullptr) axis[i] = pose.quat.z_axis();
  }
  pose.pos = pose.pos + pose.quat.turn(chain.tool_offset);
  const QuatOf<V> last = pose.quat.times(chain.tool_quat);
  const V scale = 1.0 / root(last.w * last.w + last.x * last.x + last.y * last.y + last.z * last.z);
  pose.quat = {last.w * scale, last.x * scale, last.y * scale, last.z * scale};
  if (jacobian != nullptr) {
    for (int i = 0; i < kArmJoints; ++i) {
      const Vec3Of<V> linear = cross(axis[i], pose.pos - origin[i]);
      const V values[6] = {linear.x, linear.y, linear.z, axis[i].x, axis[i].y, axis[i].z};
      for (int k = 0; k < 6; ++k) jacobian->column[i][k] = values[k];
    }
  }
  return pose;
}

// pinv(J) twist by way of the normal equations. Returns where they are well conditioned; elsewhere
// `step` means nothing.
template <class V>
ENGRAM_LANES_INLINE auto minimum_norm_step(const ToolJacobian<V>& jacobian, const V* twist,
                                           V* step) {
  constexpr double kWellConditioned = 1e-4;  // smallest over largest pivot
  V factor[6][6];                            // Cholesky's, lower triangle
  V pivot[6];                                // its inverse diagonal
  V least = {};
  V largest = {};
  auto well = least == largest;
  for (int i = 0; i < 6; ++i) {
    for (int k = 0; k <= i; ++k) {
      V sum = {};
      for (int joint = 0; joint < kArmJoints; ++joint) {
        sum += jacobian.column[joint][i] * jacobian.column[joint][k];
      }
      for (int j = 0; j < k; ++j) sum -= factor[i][j] * factor[k][j];
      if (k < i) {
        factor[i][k] = sum * pivot[k];
      } else {
        const V diagonal = root(sum);
        well = both(well, diagonal > 0.0);
        pivot[i] = 1.0 / diagonal;
        least = i == 0 ? diagonal : lesser(diagonal, least);
        largest = i == 0 ? diagonal : greater(diagonal, largest);
      }
    }
  }
  V solved[6];
  for (int i = 0; i < 6; ++i) {
    solved[i] = twist[i];
    for (int k = 0; k < i; ++k) solved[i] -= factor[i][k] * solved[k];
    solved[i] *= pivot[i];
  }
  for (int i = 5; i >= 0; --i) {
    for (int k = i + 1; k < 6; ++k) solved[i] -= factor[k][i] * solved[k];
    solved[i] *= pivot[i];
  }
  for (int joint = 0; joint < kArmJoints; ++joint) {
    step[joint] = V{};
    for (int k = 0; k < 6; ++k) step[joint] += jacobian.column[joint][k] * solved[k];
  }
  return both(well, least > kWellConditioned * largest);
}

}  // namespace ENGRAM_LANES
}  // namespace engram
