// Forward kinematics of the arm: of its links, and of the TCP; and differential inverse kinematics:
// from a displacement of the TCP to a step of the joints; for one robot or for many side by side.
#pragma once

#include "core/math/sine_cosine.h"
#include "core/math/vec3.h"
#include "core/robot/joint_rows.h"
#include "core/robot/robot_model.h"

namespace engram {
inline namespace ENGRAM_ISA {

template <class V>
struct LinkPose {
  Vec3Of<V> pos;  // m, from the base
  Mat3Of<V> axes;
};

template <class V>
using LinkPoses = RowsOf<V, LinkPose, kArmJoints>;

// Forward kinematics of the arm's links by rotation matrices.
template <class V>
ENGRAM_INLINE void link_poses(const RobotModelOf<simd::ScalarOf<V>>& robot, const JointsOf<V>& q,
                              LinkPoses<V>& links) {
  RowOf<V, kArmJoints> sines;
  RowOf<V, kArmJoints> cosines;
  for (int i = 0; i < kArmJoints; i += kGroup<V>) {
    WideOf<V> sine;
    WideOf<V> cosine;
    sine_cosine(q.group(i), sine, cosine);
    sines.set_group(i, sine);
    cosines.set_group(i, cosine);
  }
  LinkPose<V> pose;
  pose.pos = broadcast_vec3<V>(robot.links[0].offset);
  for (int k = 0; k < 9; ++k) pose.axes.at[k] = simd::broadcast<V>(robot.links[0].rotation[k]);
  for (int i = 0; i < kArmJoints; ++i) {
    if (i > 0) {
      pose.pos = pose.pos + pose.axes * robot.links[i].offset;
      pose.axes = pose.axes.times(robot.links[i].rotation);
    }
    pose.axes = pose.axes.rotated_z(sines[i], cosines[i]);
    links.set(i, pose);
  }
}

template <class V>
struct TcpPose {
  Vec3Of<V> pos;   // m, from the base
  QuatOf<V> quat;  // normalised
};

// Velocity of the TCP, linear, then angular, by a unit of each joint's.
template <class V>
struct TcpJacobian {
  V column[kArmJoints][6];
};

// Forward kinematics of the TCP by quaternions. `jacobian` may be null.
template <class V>
ENGRAM_INLINE TcpPose<V> arm_forward_kinematics(const RobotModelOf<simd::ScalarOf<V>>& robot,
                                                const V* q, TcpJacobian<V>* jacobian) {
  Vec3Of<V> origin[kArmJoints];
  Vec3Of<V> axis[kArmJoints];
  TcpPose<V> pose = {{}, {simd::broadcast<V>(1), V{}, V{}, V{}}};
  for (int i = 0; i < kArmJoints; ++i) {
    V sine;
    V cosine;
    sine_cosine(0.5F * q[i], sine, cosine);
    pose.pos = pose.pos + pose.quat * robot.links[i].offset;
    pose.quat = pose.quat.times(robot.link_quat[i]).rotated_z(sine, cosine);
    origin[i] = pose.pos;
    if (jacobian != nullptr) axis[i] = pose.quat.z_axis();
  }
  pose.pos = pose.pos + pose.quat * robot.tcp_offset;
  const QuatOf<V> last = pose.quat.times(robot.tcp_quat);
  const V scale =
      1.0F / simd::sqrt(last.w * last.w + last.x * last.x + last.y * last.y + last.z * last.z);
  pose.quat = {last.w * scale, last.x * scale, last.y * scale, last.z * scale};
  if (jacobian != nullptr) {
    for (int i = 0; i < kArmJoints; ++i) {
      const Vec3Of<V> linear = cross(axis[i], pose.pos - origin[i]);
      for (int k = 0; k < 3; ++k) {
        jacobian->column[i][k] = linear[k];
        jacobian->column[i][3 + k] = axis[i][k];
      }
    }
  }
  return pose;
}

// pinv(J) displacement by a Cholesky factorisation of the normal equations. Returns where they are
// well conditioned; elsewhere `step` means nothing.
template <class V>
ENGRAM_INLINE auto minimum_norm_step(const TcpJacobian<V>& jacobian, const V* displacement,
                                     V* step) {
  using Scalar = simd::ScalarOf<V>;
  constexpr bool kIsFloat = sizeof(Scalar) == sizeof(float);
  // Smallest over largest pivot.
  constexpr auto kWellConditioned = static_cast<Scalar>(kIsFloat ? 3e-2 : 1e-4);
  V factor[6][6];  // lower triangle
  V pivot[6];      // its inverse diagonal
  V least = {};
  V largest = {};
  auto good = least == largest;
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
        const V diagonal = simd::sqrt(sum);
        good = simd::logical_and(good, diagonal > 0.0F);
        pivot[i] = 1.0F / diagonal;
        least = i == 0 ? diagonal : simd::min(diagonal, least);
        largest = i == 0 ? diagonal : simd::max(diagonal, largest);
      }
    }
  }
  const auto solve = [&](const V* right, V* solved) ENGRAM_INLINE_LAMBDA {
    for (int i = 0; i < 6; ++i) {
      V sum = right[i];
      for (int k = 0; k < i; ++k) sum -= factor[i][k] * solved[k];
      solved[i] = sum * pivot[i];
    }
    for (int i = 5; i >= 0; --i) {
      for (int k = i + 1; k < 6; ++k) solved[i] -= factor[k][i] * solved[k];
      solved[i] *= pivot[i];
    }
    for (int joint = 0; joint < kArmJoints; ++joint) {
      step[joint] = V{};
      for (int k = 0; k < 6; ++k) step[joint] += jacobian.column[joint][k] * solved[k];
    }
  };
  V solved[6];
  solve(displacement, solved);
  if constexpr (kIsFloat) {
    // The normal equations lose twice the digits that the Jacobian costs: one refinement.
    V rest[6];
    V first[kArmJoints];
    for (int joint = 0; joint < kArmJoints; ++joint) first[joint] = step[joint];
    for (int k = 0; k < 6; ++k) {
      rest[k] = displacement[k];
      for (int joint = 0; joint < kArmJoints; ++joint) {
        rest[k] -= jacobian.column[joint][k] * first[joint];
      }
    }
    solve(rest, solved);
    for (int joint = 0; joint < kArmJoints; ++joint) step[joint] += first[joint];
  }
  return simd::logical_and(good, least > kWellConditioned * largest);
}

}  // namespace ENGRAM_ISA
}  // namespace engram
