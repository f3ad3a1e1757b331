// Kinematics and dynamics of the robot, for one or for many side by side: where its links are, the
// inertia matrix of its joints, and the forces that turning links put on them.
#pragma once

#include "core/math/sine_cosine.h"
#include "core/robot/joint_solver.h"
#include "core/robot/robot_model.h"

namespace engram {
inline namespace ENGRAM_LANES {

template <class V>
struct Vec3Of {
  V x, y, z;

  ENGRAM_LANES_INLINE friend Vec3Of operator+(const Vec3Of& a, const Vec3Of& b) {
    return {a.x + b.x, a.y + b.y, a.z + b.z};
  }
  ENGRAM_LANES_INLINE friend Vec3Of operator-(const Vec3Of& a, const Vec3Of& b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
  }
  ENGRAM_LANES_INLINE friend Vec3Of operator*(const Vec3Of& a, V s) {
    return {a.x * s, a.y * s, a.z * s};
  }
};

template <class V>
ENGRAM_LANES_INLINE V dot(const Vec3Of<V>& a, const Vec3Of<V>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class V>
ENGRAM_LANES_INLINE Vec3Of<V> cross(const Vec3Of<V>& a, const Vec3Of<V>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

// Axes of a frame are the columns.
template <class V>
struct Mat3Of {
  V at[9];  // row by row

  ENGRAM_LANES_INLINE Vec3Of<V> column(int k) const { return {at[k], at[3 + k], at[6 + k]}; }
  ENGRAM_LANES_INLINE Vec3Of<V> operator*(const double* v) const {
    return {at[0] * v[0] + at[1] * v[1] + at[2] * v[2], at[3] * v[0] + at[4] * v[1] + at[5] * v[2],
            at[6] * v[0] + at[7] * v[1] + at[8] * v[2]};
  }
  ENGRAM_LANES_INLINE Mat3Of times(const double* m) const {
    Mat3Of result;
    for (int i = 0; i < 3; ++i) {
      for (int k = 0; k < 3; ++k) {
        result.at[3 * i + k] =
            at[3 * i] * m[k] + at[3 * i + 1] * m[3 + k] + at[3 * i + 2] * m[6 + k];
      }
    }
    return result;
  }
  // Turned about its own z axis.
  ENGRAM_LANES_INLINE Mat3Of turned(V sine, V cosine) const {
    Mat3Of result = *this;
    for (int i = 0; i < 9; i += 3) {
      result.at[i] = at[i] * cosine + at[i + 1] * sine;
      result.at[i + 1] = at[i + 1] * cosine - at[i] * sine;
    }
    return result;
  }
};

// Of motion: angular and linear velocity of the point at the base's origin; of force: torque about
// that origin, and force.
template <class V>
struct SpatialOf {
  Vec3Of<V> angular, linear;
};
template <class V>
ENGRAM_LANES_INLINE V power(const SpatialOf<V>& motion, const SpatialOf<V>& force) {
  return dot(motion.angular, force.angular) + dot(motion.linear, force.linear);
}

// About the base's origin.
template <class V>
struct InertiaOf {
  V xx, yy, zz, xy, xz, yz;
  Vec3Of<V> moment;  // mass times centre
  double mass;

  ENGRAM_LANES_INLINE SpatialOf<V> operator*(const SpatialOf<V>& v) const {
    const Vec3Of<V>& w = v.angular;
    const Vec3Of<V> turning = {xx * w.x + xy * w.y + xz * w.z, xy * w.x + yy * w.y + yz * w.z,
                               xz * w.x + yz * w.y + zz * w.z};
    return {turning + cross(moment, v.linear),
            v.linear * spread<V>(mass) + cross(v.angular, moment)};
  }
  ENGRAM_LANES_INLINE void add(const InertiaOf& other) {
    xx += other.xx, yy += other.yy, zz += other.zz;
    xy += other.xy, xz += other.xz, yz += other.yz;
    moment = moment + other.moment;
    mass += other.mass;
  }
};

// Of a body whose inertia is given in `axes`, with its centre of mass at `center`.
template <class V>
ENGRAM_LANES_INLINE InertiaOf<V> inertia_of(const RobotModel::Link& link, const Mat3Of<V>& axes,
                                            const Vec3Of<V>& center) {
  const double* c = link.inertia;
  const double square[9] = {c[0], c[3], c[4], c[3], c[1], c[5], c[4], c[5], c[2]};
  const Mat3Of<V> half = axes.times(square);
  const V* a = half.at;
  const V* b = axes.at;
  const auto entry = [a, b](int i, int k) {
    return a[3 * i] * b[3 * k] + a[3 * i + 1] * b[3 * k + 1] + a[3 * i + 2] * b[3 * k + 2];
  };
  const Vec3Of<V> moment = center * spread<V>(link.mass);
  const V x = moment.x * center.x;
  const V y = moment.y * center.y;
  const V z = moment.z * center.z;
  return {entry(0, 0) + (y + z),
          entry(1, 1) + (x + z),
          entry(2, 2) + (x + y),
          entry(0, 1) - moment.x * center.y,
          entry(0, 2) - moment.x * center.z,
          entry(1, 2) - moment.y * center.z,
          moment,
          link.mass};
}

template <class V>
struct LinkPose {
  Vec3Of<V> pos;  // m, from the base
  Mat3Of<V> axes;
};

// Of the joints of the arm.
template <class V>
ENGRAM_LANES_INLINE void link_poses(const RobotModel& chain, const V* q, LinkPose<V>* links) {
  for (int i = 0; i < kArmJoints; ++i) {
    V sine;
    V cosine;
    sine_cosine(q[i], sine, cosine);
    const RobotModel::Link& about = chain.arm[i];
    if (i == 0) {
      links[0].pos = {spread<V>(about.offset[0]), spread<V>(about.offset[1]),
                      spread<V>(about.offset[2])};
      for (int k = 0; k < 9; ++k) links[0].axes.at[k] = spread<V>(about.turn[k]);
    } else {
      links[i].pos = links[i - 1].pos + links[i - 1].axes * about.offset;
      links[i].axes = links[i - 1].axes.times(about.turn);
    }
    links[i].axes = links[i].axes.turned(sine, cosine);
  }
}

// The inertia matrix and the bias forces of the joints, for links where they are.
template <class V>
class RobotDynamics {
 public:
  ENGRAM_LANES_INLINE RobotDynamics(const RobotModel& chain, const V* q, const LinkPose<V>* links)
      : chain_(chain) {
    for (int i = 0; i < kArmJoints; ++i) {
      const Vec3Of<V> axis = links[i].axes.column(2);
      axis_[i] = {axis, cross(links[i].pos, axis)};
      inertia_[i] = inertia_of(chain.arm[i], links[i].axes,
                               links[i].pos + links[i].axes * chain.arm[i].center);
    }
    const LinkPose<V>& last = links[kArmJoints - 1];
    for (int k = 0; k < kFingers; ++k) {
      const RobotModel::Link& about = chain.finger[k];
      slide_[k] = last.axes * chain.slide[k];
      const double at[3] = {about.offset[0] + about.center[0], about.offset[1] + about.center[1],
                            about.offset[2] + about.center[2]};
      finger_[k] =
          inertia_of(about, last.axes, last.pos + last.axes * at + slide_[k] * q[kArmJoints + k]);
    }
  }

  // The whole matrix. Joints of the arm come first.
  ENGRAM_LANES_INLINE void inertia(JointMatrixOf<V>& matrix) const {
    InertiaOf<V> carried = inertia_[kArmJoints - 1];
    for (int k = 0; k < kFingers; ++k) {
      const int finger = kArmJoints + k;
      carried.add(finger_[k]);
      const SpatialOf<V> force = {cross(finger_[k].moment, slide_[k]),
                                  slide_[k] * spread<V>(finger_[k].mass)};
      for (int i = 0; i < kArmJoints; ++i) set(matrix, finger, i, power(axis_[i], force));
      set(matrix, finger, finger, spread<V>(finger_[k].mass));
    }
    set(matrix, kArmJoints, kArmJoints + 1, V{});
    for (int i = kArmJoints - 1; i >= 0; --i) {
      if (i < kArmJoints - 1) carried.add(inertia_[i]);
      const SpatialOf<V> force = carried * axis_[i];
      for (int k = 0; k <= i; ++k) set(matrix, i, k, power(axis_[k], force));
    }
  }

  // Coriolis and centrifugal forces at joint velocities v.
  ENGRAM_LANES_INLINE void bias(const V* v, V* forces) const {
    SpatialOf<V> force[kArmJoints];
    SpatialOf<V> velocity = {axis_[0].angular * v[0], axis_[0].linear * v[0]};
    SpatialOf<V> acceleration = {};
    force[0] = force_on(inertia_[0], velocity, acceleration);
    for (int i = 1; i < kArmJoints; ++i) {
      const SpatialOf<V>& axis = axis_[i];
      acceleration.angular = acceleration.angular + cross(velocity.angular, axis.angular) * v[i];
      acceleration.linear =
          acceleration.linear +
          (cross(velocity.angular, axis.linear) + cross(velocity.linear, axis.angular)) * v[i];
      velocity.angular = velocity.angular + axis.angular * v[i];
      velocity.linear = velocity.linear + axis.linear * v[i];
      force[i] = force_on(inertia_[i], velocity, acceleration);
    }
    for (int k = 0; k < kFingers; ++k) {
      const V speed = v[kArmJoints + k];
      const SpatialOf<V> moving = {velocity.angular, velocity.linear + slide_[k] * speed};
      const SpatialOf<V> pulled = {
          acceleration.angular, acceleration.linear + cross(velocity.angular, slide_[k]) * speed};
      const SpatialOf<V> on_finger = force_on(finger_[k], moving, pulled);
      forces[kArmJoints + k] = dot(slide_[k], on_finger.linear);
      force[kArmJoints - 1].angular = force[kArmJoints - 1].angular + on_finger.angular;
      force[kArmJoints - 1].linear = force[kArmJoints - 1].linear + on_finger.linear;
    }
    for (int i = kArmJoints - 1; i >= 0; --i) {
      forces[i] = power(axis_[i], force[i]);
      if (i == 0) break;
      force[i - 1].angular = force[i - 1].angular + force[i].angular;
      force[i - 1].linear = force[i - 1].linear + force[i].linear;
    }
  }

 private:
  ENGRAM_LANES_INLINE static void set(JointMatrixOf<V>& matrix, int i, int k, V value) {
    matrix[i][k] = value;
    matrix[k][i] = value;
  }

  ENGRAM_LANES_INLINE static SpatialOf<V> force_on(const InertiaOf<V>& inertia,
                                                   const SpatialOf<V>& velocity,
                                                   const SpatialOf<V>& acceleration) {
    const SpatialOf<V> momentum = inertia * velocity;
    const SpatialOf<V> pull = inertia * acceleration;
    return {pull.angular + (cross(velocity.angular, momentum.angular) +
                            cross(velocity.linear, momentum.linear)),
            pull.linear + cross(velocity.angular, momentum.linear)};
  }

  const RobotModel& chain_;
  SpatialOf<V> axis_[kArmJoints];  // of each hinge's turning
  Vec3Of<V> slide_[kFingers];
  InertiaOf<V> inertia_[kArmJoints];
  InertiaOf<V> finger_[kFingers];
};

}  // namespace ENGRAM_LANES
}  // namespace engram
