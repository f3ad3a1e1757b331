// Dynamics of the robot, for one or for many side by side: the mass matrix of its joints and their
// bias forces.
#pragma once

#include "core/math/vec3.h"
#include "core/robot/arm_kinematics.h"
#include "core/robot/joint_solver.h"
#include "core/robot/robot_model.h"

namespace engram {
inline namespace ENGRAM_ISA {

// Spatial vectors. Motion: angular velocity, and linear velocity of the point at the base's origin;
// force: torque about that origin, and force.
template <class V>
struct SpatialOf {
  Vec3Of<V> angular, linear;
};
template <class V>
ENGRAM_INLINE V dot(const SpatialOf<V>& motion, const SpatialOf<V>& force) {
  return dot(motion.angular, force.angular) + dot(motion.linear, force.linear);
}

// Spatial inertia about the base's origin.
template <class V>
struct InertiaOf {
  V xx, yy, zz, xy, xz, yz;
  Vec3Of<V> moment;  // mass times centre
  double mass;

  ENGRAM_INLINE SpatialOf<V> operator*(const SpatialOf<V>& v) const {
    const Vec3Of<V>& w = v.angular;
    const Vec3Of<V> angular = {xx * w.x() + xy * w.y() + xz * w.z(),
                               xy * w.x() + yy * w.y() + yz * w.z(),
                               xz * w.x() + yz * w.y() + zz * w.z()};
    return {angular + cross(moment, v.linear),
            v.linear * simd::broadcast<V>(mass) + cross(v.angular, moment)};
  }
  ENGRAM_INLINE void add(const InertiaOf& other) {
    xx += other.xx, yy += other.yy, zz += other.zz;
    xy += other.xy, xz += other.xz, yz += other.yz;
    moment = moment + other.moment;
    mass += other.mass;
  }
};

// Spatial inertia of a body whose inertia is given in `axes`, with its centre of mass at `center`.
template <class V>
ENGRAM_INLINE InertiaOf<V> inertia_of(const RobotModel::Link& link, const Mat3Of<V>& axes,
                                      const Vec3Of<V>& center) {
  const double* c = link.inertia;
  const double tensor[9] = {c[0], c[3], c[4], c[3], c[1], c[5], c[4], c[5], c[2]};
  const Mat3Of<V> half = axes.times(tensor);
  const V* a = half.at;
  const V* b = axes.at;
  const auto entry = [a, b](int i, int k) {
    return a[3 * i] * b[3 * k] + a[3 * i + 1] * b[3 * k + 1] + a[3 * i + 2] * b[3 * k + 2];
  };
  const Vec3Of<V> moment = center * simd::broadcast<V>(link.mass);
  const V x = moment.x() * center.x();
  const V y = moment.y() * center.y();
  const V z = moment.z() * center.z();
  return {entry(0, 0) + (y + z),
          entry(1, 1) + (x + z),
          entry(2, 2) + (x + y),
          entry(0, 1) - moment.x() * center.y(),
          entry(0, 2) - moment.x() * center.z(),
          entry(1, 2) - moment.y() * center.z(),
          moment,
          link.mass};
}

// Mass matrix and bias forces of the joints, for links at these poses.
template <class V>
class RobotDynamics {
 public:
  ENGRAM_INLINE RobotDynamics(const RobotModel& robot, const V* q, const LinkPose<V>* links) {
    for (int i = 0; i < kArmJoints; ++i) {
      const Vec3Of<V> axis = links[i].axes.column(2);
      axis_[i] = {axis, cross(links[i].pos, axis)};
      link_inertia_[i] = inertia_of(robot.links[i], links[i].axes,
                                    links[i].pos + links[i].axes * robot.links[i].center);
    }
    const LinkPose<V>& last = links[kArmJoints - 1];
    for (int k = 0; k < kFingers; ++k) {
      const RobotModel::Link& finger = robot.fingers[k];
      finger_axis_[k] = last.axes * robot.finger_axis[k];
      const double at[3] = {finger.offset[0] + finger.center[0],
                            finger.offset[1] + finger.center[1],
                            finger.offset[2] + finger.center[2]};
      finger_inertia_[k] = inertia_of(
          finger, last.axes, last.pos + last.axes * at + finger_axis_[k] * q[kArmJoints + k]);
    }
  }

  // Composite rigid body algorithm (CRBA). The whole matrix; joints of the arm come first.
  ENGRAM_INLINE void mass_matrix(JointMatrixOf<V>& matrix) const {
    InertiaOf<V> composite = link_inertia_[kArmJoints - 1];
    for (int k = 0; k < kFingers; ++k) {
      const int finger = kArmJoints + k;
      composite.add(finger_inertia_[k]);
      const SpatialOf<V> force = {cross(finger_inertia_[k].moment, finger_axis_[k]),
                                  finger_axis_[k] * simd::broadcast<V>(finger_inertia_[k].mass)};
      for (int i = 0; i < kArmJoints; ++i) set(matrix, finger, i, dot(axis_[i], force));
      set(matrix, finger, finger, simd::broadcast<V>(finger_inertia_[k].mass));
    }
    set(matrix, kArmJoints, kArmJoints + 1, V{});
    for (int i = kArmJoints - 1; i >= 0; --i) {
      if (i < kArmJoints - 1) composite.add(link_inertia_[i]);
      const SpatialOf<V> force = composite * axis_[i];
      for (int k = 0; k <= i; ++k) set(matrix, i, k, dot(axis_[k], force));
    }
  }

  // Recursive Newton-Euler algorithm (RNEA) without gravity and accelerations: Coriolis and
  // centrifugal forces at joint velocities v.
  ENGRAM_INLINE void bias_force(const V* v, V* forces) const {
    SpatialOf<V> force[kArmJoints];
    SpatialOf<V> velocity = {axis_[0].angular * v[0], axis_[0].linear * v[0]};
    SpatialOf<V> acceleration = {};
    force[0] = force_on(link_inertia_[0], velocity, acceleration);
    for (int i = 1; i < kArmJoints; ++i) {
      const SpatialOf<V>& axis = axis_[i];
      acceleration.angular = acceleration.angular + cross(velocity.angular, axis.angular) * v[i];
      acceleration.linear =
          acceleration.linear +
          (cross(velocity.angular, axis.linear) + cross(velocity.linear, axis.angular)) * v[i];
      velocity.angular = velocity.angular + axis.angular * v[i];
      velocity.linear = velocity.linear + axis.linear * v[i];
      force[i] = force_on(link_inertia_[i], velocity, acceleration);
    }
    for (int k = 0; k < kFingers; ++k) {
      const V speed = v[kArmJoints + k];
      const SpatialOf<V> moving = {velocity.angular, velocity.linear + finger_axis_[k] * speed};
      const SpatialOf<V> pulled = {
          acceleration.angular,
          acceleration.linear + cross(velocity.angular, finger_axis_[k]) * speed};
      const SpatialOf<V> on_finger = force_on(finger_inertia_[k], moving, pulled);
      forces[kArmJoints + k] = dot(finger_axis_[k], on_finger.linear);
      force[kArmJoints - 1].angular = force[kArmJoints - 1].angular + on_finger.angular;
      force[kArmJoints - 1].linear = force[kArmJoints - 1].linear + on_finger.linear;
    }
    for (int i = kArmJoints - 1; i >= 0; --i) {
      forces[i] = dot(axis_[i], force[i]);
      if (i == 0) break;
      force[i - 1].angular = force[i - 1].angular + force[i].angular;
      force[i - 1].linear = force[i - 1].linear + force[i].linear;
    }
  }

 private:
  ENGRAM_INLINE static void set(JointMatrixOf<V>& matrix, int i, int k, V value) {
    matrix[i][k] = value;
    matrix[k][i] = value;
  }

  ENGRAM_INLINE static SpatialOf<V> force_on(const InertiaOf<V>& inertia,
                                             const SpatialOf<V>& velocity,
                                             const SpatialOf<V>& acceleration) {
    const SpatialOf<V> momentum = inertia * velocity;
    const SpatialOf<V> pull = inertia * acceleration;
    return {pull.angular + (cross(velocity.angular, momentum.angular) +
                            cross(velocity.linear, momentum.linear)),
            pull.linear + cross(velocity.angular, momentum.linear)};
  }

  SpatialOf<V> axis_[kArmJoints];  // motion of a unit of each hinge
  Vec3Of<V> finger_axis_[kFingers];
  InertiaOf<V> link_inertia_[kArmJoints];
  InertiaOf<V> finger_inertia_[kFingers];
};

}  // namespace ENGRAM_ISA
}  // namespace engram
