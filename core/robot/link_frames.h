// World geometry of the robot's links at one configuration, from which Jacobians follow: hinges,
// slide directions and centres of mass, from the base, for one robot or for many side by side.
#pragma once

#include "core/robot/arm_kinematics.h"
#include "core/robot/joint_solver.h"

namespace engram {
inline namespace ENGRAM_ISA {

template <class V>
class LinkFrames {
 public:
  using Robot = RobotModelOf<simd::ScalarOf<V>>;

  // `links` must outlive this object.
  ENGRAM_INLINE LinkFrames(const Robot& robot, const JointsOf<V>& q, const LinkPoses<V>& links)
      : robot_(robot), links_(links) {
    const LinkPose<V> last = links[kArmJoints - 1];
    for (int k = 0; k < kFingers; ++k) {
      finger_axis_[k] = last.axes * robot.finger_axis[k];
      opening_[k] = q[kArmJoints + k];
    }
  }

  // Origin and axis of a hinge.
  ENGRAM_INLINE Vec3Of<V> origin(int hinge) const { return links_[hinge].pos; }
  ENGRAM_INLINE Vec3Of<V> axis(int hinge) const { return links_[hinge].axes.column(2); }
  // Direction in which a finger opens.
  ENGRAM_INLINE const Vec3Of<V>& finger_axis(int finger) const { return finger_axis_[finger]; }
  // Centre of mass of a link, m.
  ENGRAM_INLINE Vec3Of<V> center(int link) const {
    const LinkPose<V> carrier = links_[hinges_of(link) - 1];
    const Vec3Of<V> center = carrier.pos + carrier.axes * robot_.centers[link];
    const int finger = finger_of(link);
    return finger < 0 ? center : center + finger_axis_[finger] * opening_[finger];
  }

  // Jacobian of the centre of mass of a link: rows for the world's x, y and z.
  ENGRAM_INLINE void center_jacobian(int link, JointsOf<V>* rows) const {
    const Vec3Of<V> point = center(link);
    for (int k = 0; k < 3; ++k) rows[k] = {};
    for (int i = 0; i < hinges_of(link); ++i) {
      const Vec3Of<V> column = cross(axis(i), point - origin(i));
      for (int k = 0; k < 3; ++k) rows[k][i] = column[k];
    }
    const int finger = finger_of(link);
    if (finger < 0) return;
    for (int k = 0; k < 3; ++k) rows[k][kArmJoints + finger] = finger_axis_[finger][k];
  }

  // Acceleration of a link by joint velocities v alone: centripetal and Coriolis accelerations of
  // its centre of mass, m/s^2, and its angular one, rad/s^2.
  ENGRAM_INLINE void bias_acceleration(int link, const JointsOf<V>& v, Vec3Of<V>& linear,
                                       Vec3Of<V>& angular) const {
    Vec3Of<V> spin = {};  // angular velocity
    linear = angular = {};
    const auto go_to = [&](const Vec3Of<V>& lever) {
      linear = linear + cross(angular, lever) + cross(spin, cross(spin, lever));
    };
    const int last = hinges_of(link) - 1;
    for (int i = 0; i <= last; ++i) {
      if (i > 0) go_to(origin(i) - origin(i - 1));
      const Vec3Of<V> turn = axis(i) * v[i];
      angular = angular + cross(spin, turn);
      spin = spin + turn;
    }
    go_to(center(link) - origin(last));
    const int finger = finger_of(link);
    if (finger < 0) return;
    linear = linear + cross(spin, finger_axis_[finger]) * (2.0F * v[kArmJoints + finger]);
  }

  // Compliance of a link in contacts and joint limits: a share of the largest response of its
  // centre of mass to an impulse along x, y or z, 1/kg.
  ENGRAM_INLINE V compliance(int link, const JointMatrixOf<V>& inv_mass) const {
    constexpr float kShare = 0.25F;
    const int hinges = hinges_of(link);
    const int finger = finger_of(link);
    JointsOf<V> rows[3];
    center_jacobian(link, rows);
    V largest = {};
    for (int direction = 0; direction < 3; ++direction) {
      const JointsOf<V>& row = rows[direction];
      V response = {};
      for (int i = 0; i < hinges; ++i) {
        V sum = {};
        for (int k = 0; k < hinges; ++k) sum += inv_mass[i][k] * row[k];
        if (finger >= 0)
          sum += 2.0F * (inv_mass[i][kArmJoints + finger] * row[kArmJoints + finger]);
        response += row[i] * sum;
      }
      if (finger >= 0) {
        const int joint = kArmJoints + finger;
        response += row[joint] * (inv_mass[joint][joint] * row[joint]);
      }
      largest = direction == 0 ? response : simd::max(largest, response);
    }
    return kShare * largest;
  }

  // The greater compliance of the two links that a joint connects.
  ENGRAM_INLINE V joint_compliance(int joint, const JointMatrixOf<V>& inv_mass) const {
    const V own = compliance(joint, inv_mass);
    if (joint == 0) return own;
    return simd::max(own, compliance(joint < kArmJoints ? joint - 1 : kHandLink, inv_mass));
  }

 private:
  const Robot& robot_;
  const LinkPoses<V>& links_;
  Vec3Of<V> finger_axis_[kFingers];
  V opening_[kFingers];
};

}  // namespace ENGRAM_ISA
}  // namespace engram
