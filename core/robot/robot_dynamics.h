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

  ENGRAM_INLINE friend SpatialOf operator+(const SpatialOf& a, const SpatialOf& b) {
    return {a.angular + b.angular, a.linear + b.linear};
  }
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
  V mass;

  ENGRAM_INLINE SpatialOf<V> operator*(const SpatialOf<V>& v) const {
    const Vec3Of<V>& w = v.angular;
    const Vec3Of<V> angular = {xx * w.x() + xy * w.y() + xz * w.z(),
                               xy * w.x() + yy * w.y() + yz * w.z(),
                               xz * w.x() + yz * w.y() + zz * w.z()};
    return {angular + cross(moment, v.linear), v.linear * mass + cross(v.angular, moment)};
  }
  ENGRAM_INLINE void add(const InertiaOf& other) {
    xx += other.xx, yy += other.yy, zz += other.zz;
    xy += other.xy, xz += other.xz, yz += other.yz;
    moment = moment + other.moment;
    mass += other.mass;
  }
};

// Spatial inertia of a body of this mass and inertia about its centre of mass, in `axes`.
template <class V>
ENGRAM_INLINE InertiaOf<V> inertia_of(V mass, const V* inertia, const Mat3Of<V>& axes,
                                      const Vec3Of<V>& center) {
  const V* c = inertia;
  const V tensor[9] = {c[0], c[3], c[4], c[3], c[1], c[5], c[4], c[5], c[2]};
  const Mat3Of<V> half = axes.times(tensor);
  const V* a = half.at;
  const V* b = axes.at;
  const auto entry = [a, b](int i, int k) {
    return a[3 * i] * b[3 * k] + a[3 * i + 1] * b[3 * k + 1] + a[3 * i + 2] * b[3 * k + 2];
  };
  const Vec3Of<V> moment = center * mass;
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
          mass};
}

// Mass matrix and bias forces of the joints, for links at these poses. Groups of links are computed
// together (see RowOf), but for what goes from link to link.
template <class V>
class RobotDynamics {
 public:
  using Scalar = simd::ScalarOf<V>;
  using Robot = RobotModelOf<Scalar>;

  ENGRAM_INLINE RobotDynamics(const Robot& robot, const JointsOf<V>& q, const LinkPoses<V>& links) {
    for (int i = 0; i < kArmJoints; i += kGroup<V>) {
      const LinkPose<Wide> link = links.group(i);
      const Vec3Of<Wide> axis = link.axes.column(2);
      axes_.set_group(i, {axis, cross(link.pos, axis)});
      const Bodies bodies(robot.links, kArmJoints, i);
      inertias_.set_group(i, bodies.inertia(link.axes, link.pos + link.axes * bodies.center));
    }
    const LinkPose<V> last = links[kArmJoints - 1];
    for (int k = 0; k < kFingers; ++k) finger_axes_.set(k, last.axes * robot.finger_axis[k]);
    const LinkPose<Wide> carrier = spread(last);
    for (int k = 0; k < kFingers; k += kGroup<V>) {
      const Bodies bodies(robot.fingers, kFingers, k);
      const Vec3Of<Wide> center = carrier.pos + carrier.axes * (bodies.offset + bodies.center) +
                                  finger_axes_.group(k) * q.group(kArmJoints + k);
      finger_inertias_.set_group(k, bodies.inertia(carrier.axes, center));
    }
  }

  // Composite rigid body algorithm (CRBA). The whole matrix; joints of the arm come first.
  ENGRAM_INLINE void mass_matrix(JointMatrixOf<V>& matrix) const {
    RowsOf<V, InertiaOf, kArmJoints> composites;
    InertiaOf<V> composite = inertias_[kArmJoints - 1];
    for (int k = 0; k < kFingers; ++k) composite.add(finger_inertias_[k]);
    composites.set(kArmJoints - 1, composite);
    for (int i = kArmJoints - 2; i >= 0; --i) {
      composite.add(inertias_[i]);
      composites.set(i, composite);
    }
    RowsOf<V, SpatialOf, kArmJoints> forces;
    for (int i = 0; i < kArmJoints; i += kGroup<V>) {
      forces.set_group(i, composites.group(i) * axes_.group(i));
    }
    for (int i = 0; i < kArmJoints; ++i) set_row(matrix, i, i, forces[i]);
    for (int k = 0; k < kFingers; ++k) {
      const InertiaOf<V> inertia = finger_inertias_[k];
      const Vec3Of<V> axis = finger_axes_[k];
      set_row(matrix, kArmJoints + k, kArmJoints - 1,
              {cross(inertia.moment, axis), axis * inertia.mass});
      matrix[kArmJoints + k][kArmJoints + k] = inertia.mass;
    }
    matrix[kArmJoints + 1][kArmJoints] = V{};
    for (int i = 0; i < kRobotJoints; ++i) {
      for (int k = 0; k < i; ++k) matrix[k][i] = matrix[i][k];
    }
  }

  // Recursive Newton-Euler algorithm (RNEA) without gravity and accelerations: Coriolis and
  // centrifugal forces at joint velocities v.
  ENGRAM_INLINE void bias_force(const JointsOf<V>& v, JointsOf<V>& forces) const {
    RowsOf<V, SpatialOf, kArmJoints> velocities;
    RowsOf<V, SpatialOf, kArmJoints> accelerations;
    SpatialOf<V> velocity = {axes_[0].angular * v[0], axes_[0].linear * v[0]};
    SpatialOf<V> acceleration = {};
    velocities.set(0, velocity);
    accelerations.set(0, acceleration);
    for (int i = 1; i < kArmJoints; ++i) {
      const SpatialOf<V> axis = axes_[i];
      acceleration.angular = acceleration.angular + cross(velocity.angular, axis.angular) * v[i];
      acceleration.linear =
          acceleration.linear +
          (cross(velocity.angular, axis.linear) + cross(velocity.linear, axis.angular)) * v[i];
      velocity.angular = velocity.angular + axis.angular * v[i];
      velocity.linear = velocity.linear + axis.linear * v[i];
      velocities.set(i, velocity);
      accelerations.set(i, acceleration);
    }
    RowsOf<V, SpatialOf, kArmJoints> on_links;
    for (int i = 0; i < kArmJoints; i += kGroup<V>) {
      on_links.set_group(i,
                         force_on(inertias_.group(i), velocities.group(i), accelerations.group(i)));
    }
    RowsOf<V, SpatialOf, kFingers> on_fingers;
    RowOf<V, kFingers> finger_forces;
    const SpatialOf<Wide> carrier = spread(velocity);
    const SpatialOf<Wide> carrier_acceleration = spread(acceleration);
    for (int k = 0; k < kFingers; k += kGroup<V>) {
      const Wide speed = v.group(kArmJoints + k);
      const Vec3Of<Wide> axis = finger_axes_.group(k);
      const SpatialOf<Wide> moving = {carrier.angular, carrier.linear + axis * speed};
      const SpatialOf<Wide> pulled = {
          carrier_acceleration.angular,
          carrier_acceleration.linear + cross(carrier.angular, axis) * speed};
      const SpatialOf<Wide> on_finger = force_on(finger_inertias_.group(k), moving, pulled);
      finger_forces.set_group(k, dot(axis, on_finger.linear));
      on_fingers.set_group(k, on_finger);
    }
    SpatialOf<V> sum = on_links[kArmJoints - 1];
    for (int k = 0; k < kFingers; ++k) sum = sum + on_fingers[k];
    on_links.set(kArmJoints - 1, sum);
    for (int i = kArmJoints - 2; i >= 0; --i) {
      sum = on_links[i] + sum;
      on_links.set(i, sum);
    }
    for (int i = 0; i < kArmJoints; i += kGroup<V>) {
      forces.set_group(i, dot(axes_.group(i), on_links.group(i)));
    }
    for (int k = 0; k < kFingers; ++k) forces[kArmJoints + k] = finger_forces[k];
  }

 private:
  using Wide = WideOf<V>;
  // A whole group is read from the fingers' velocities on.
  static_assert(kArmJoints + kGroup<V> <= kPadded<V, kRobotJoints>);

  // Constants of a group of rigid bodies. Entries beyond the last body repeat that one.
  struct Bodies {
    ENGRAM_INLINE Bodies(const typename Robot::Link* links, int count, int first) {
      for (int i = 0; i < kGroup<V>; ++i) {
        const typename Robot::Link& link = links[first + i < count ? first + i : count - 1];
        set(mass, i, link.mass);
        for (int k = 0; k < 3; ++k) set(offset[k], i, link.offset[k]);
        for (int k = 0; k < 3; ++k) set(center[k], i, link.center[k]);
        for (int k = 0; k < 6; ++k) set(moments[k], i, link.inertia[k]);
      }
    }
    ENGRAM_INLINE static void set(Wide& wide, int entry, Scalar value) {
      if constexpr (kGroup<V> == 1) {
        wide = simd::broadcast<V>(value);
      } else {
        wide[entry] = value;
      }
    }
    ENGRAM_INLINE InertiaOf<Wide> inertia(const Mat3Of<Wide>& axes,
                                          const Vec3Of<Wide>& center_of_mass) const {
      return inertia_of(mass, moments, axes, center_of_mass);
    }

    Wide mass;
    Vec3Of<Wide> offset;
    Vec3Of<Wide> center;
    Wide moments[6];
  };

  // Forces of the arm's joints, up to `last`, that balance a force.
  ENGRAM_INLINE void set_row(JointMatrixOf<V>& matrix, int row, int last,
                             const SpatialOf<V>& force) const {
    const SpatialOf<Wide> wide = spread(force);
    for (int k = 0; k <= last; k += kGroup<V>) {
      matrix[row].set_group(k, dot(axes_.group(k), wide));
    }
  }

  ENGRAM_INLINE static SpatialOf<Wide> force_on(const InertiaOf<Wide>& inertia,
                                                const SpatialOf<Wide>& velocity,
                                                const SpatialOf<Wide>& acceleration) {
    const SpatialOf<Wide> momentum = inertia * velocity;
    const SpatialOf<Wide> pull = inertia * acceleration;
    return {pull.angular + (cross(velocity.angular, momentum.angular) +
                            cross(velocity.linear, momentum.linear)),
            pull.linear + cross(velocity.angular, momentum.linear)};
  }

  RowsOf<V, SpatialOf, kArmJoints> axes_;  // motion of a unit of each hinge
  RowsOf<V, Vec3Of, kFingers> finger_axes_;
  RowsOf<V, InertiaOf, kArmJoints> inertias_;
  RowsOf<V, InertiaOf, kFingers> finger_inertias_;
};

}  // namespace ENGRAM_ISA
}  // namespace engram
