// The kernel of one width, compiled for one instruction set.
#pragma once

#include "core/robot/arm_kinematics.h"
#include "core/robot/lane_kernel.h"
#include "core/robot/link_frames.h"
#include "core/robot/robot_dynamics.h"

namespace engram {
inline namespace ENGRAM_ISA {

// Rows of lanes lie one after the other, in double precision.
template <class V>
ENGRAM_INLINE simd::DoublesOf<V> load_doubles(const double* vectors, int index) {
  simd::DoublesOf<V> value;
  __builtin_memcpy(&value, vectors + index * simd::kLanesOf<V>, sizeof value);
  return value;
}
template <class V>
ENGRAM_INLINE void store_doubles(double* vectors, int index, simd::DoublesOf<V> value) {
  __builtin_memcpy(vectors + index * simd::kLanesOf<V>, &value, sizeof value);
}

// Rounds to single precision.
template <class V>
ENGRAM_INLINE V load_vector(const double* vectors, int index) {
  return simd::to_floats(load_doubles<V>(vectors, index));
}
template <class V>
ENGRAM_INLINE void store_vector(double* vectors, int index, V value) {
  store_doubles<V>(vectors, index, simd::to_doubles(value));
}

template <class V>
void load_vectors(const double* vectors, int first, int count, V* to) {
  for (int i = 0; i < count; ++i) to[i] = load_vector<V>(vectors, first + i);
}
template <class V>
void store_vectors(double* vectors, int first, int count, const V* from) {
  for (int i = 0; i < count; ++i) store_vector(vectors, first + i, from[i]);
}

// All lanes but those of the mask, as bits.
template <class V, class Mask>
unsigned other_lanes(Mask mask) {
  constexpr unsigned kAll = (1U << simd::kLanesOf<V>)-1;
  return kAll & ~simd::bits(mask);
}

// Two bodies of the robot come nearer by the joints between them only.
template <class V>
unsigned clearance_exceeded(const RobotModel& model, double look_ahead, double allowance,
                            const double* vectors) {
  constexpr float kRounding = 5e-6F;  // m: more than links' poses and the sums below lose
  const RobotModelOf<float>& robot = model.single;
  V displacement = {};
  V speed = {};
  V least = simd::broadcast<V>(1);  // of what is left of the clearances
  for (int i = kRobotJoints; i-- > 0;) {
    const auto moved = load_doubles<V>(vectors, LaneVectors::kQ + i) -
                       load_doubles<V>(vectors, LaneVectors::kClearanceQpos + i);
    displacement += robot.lever_arms[i] * simd::abs(simd::to_floats(moved));
    speed += robot.lever_arms[i] * simd::abs(load_vector<V>(vectors, LaneVectors::kV + i));
    least =
        simd::min(least, load_vector<V>(vectors, LaneVectors::kSelfClearance + i) - displacement);
  }
  displacement +=
      simd::max(V{}, static_cast<float>(look_ahead) * speed - static_cast<float>(allowance));
  least = simd::min(least, load_vector<V>(vectors, LaneVectors::kClearance) - displacement);
  return other_lanes<V>(least > kRounding);
}

template <class V>
void pose_links(const RobotModel& model, double* vectors) {
  JointsOf<V> q;
  load_vectors<V>(vectors, LaneVectors::kQ, kArmJoints, q.at);
  LinkPoses<V> links;
  link_poses<V>(model.single, q, links);
  for (int i = 0; i < kArmJoints; ++i) {
    const int first = LaneVectors::kLinkPoses + 12 * i;
    const LinkPose<V> link = links[i];
    store_vectors(vectors, first, 3, link.pos.at);
    store_vectors(vectors, first + 3, 9, link.axes.at);
  }
}

// What the solver has of joint positions, which it sees as displacements only.
template <class V>
ENGRAM_INLINE void prepare_displacements(const RobotParams& params, bool velocity_mode,
                                         const double* vectors, JointSolver<V>& joints) {
  const auto position = [vectors](int joint) ENGRAM_INLINE_LAMBDA {
    return load_doubles<V>(vectors, LaneVectors::kQ + joint);
  };
  for (int i = 0; i < kRobotJoints; ++i) {
    const double stiffness = drive_stiffness<double>(params, velocity_mode, i);
    joints.stiffness[i] = static_cast<float>(stiffness);
    joints.drive_bias[i] = simd::to_floats(load_doubles<V>(vectors, LaneVectors::kDriveBias + i) -
                                           stiffness * position(i));
    joints.above[i] = simd::to_floats(position(i) - params.lower[i]);
    joints.below[i] = simd::to_floats(params.upper[i] - position(i));
  }
  joints.fingers_apart = simd::to_floats(position(kLeftFinger) - position(kRightFinger));
}

// The substep with contacts of any kind (see NoContacts): `make_contacts` makes them from the
// links' frames and the joint solver.
template <class V, class MakeContacts>
ENGRAM_INLINE void substep_with(const RobotModel& model, const RobotParams& params,
                                bool velocity_mode, double* vectors,
                                const MakeContacts& make_contacts) {
  JointSolver<V> joints;
  JointsOf<V> q;
  load_vectors<V>(vectors, LaneVectors::kQ, kRobotJoints, q.at);
  load_vectors<V>(vectors, LaneVectors::kV, kRobotJoints, joints.begin_v.at);
  prepare_displacements(params, velocity_mode, vectors, joints);
  LinkPoses<V> links;
  link_poses<V>(model.single, q, links);
  {
    const RobotDynamics<V> dynamics(model.single, q, links);
    dynamics.mass_matrix(joints.inv_mass);
    dynamics.bias_force(joints.begin_v, joints.bias_force);
  }
  joints.prepare(params.single);
  const LinkFrames<V> frames(model.single, q, links);
  auto contacts = make_contacts(frames, joints);
  joints.run(params.single, frames, contacts);
  for (int i = 0; i < kRobotJoints; ++i) {
    auto end_q =
        load_doubles<V>(vectors, LaneVectors::kQ + i) + simd::to_doubles(joints.displacement[i]);
    if (i >= kArmJoints) end_q = simd::clamp(end_q, params.lower[i], params.upper[i]);
    store_doubles<V>(vectors, LaneVectors::kEndQ + i, end_q);
  }
  store_vectors(vectors, LaneVectors::kEndV, kRobotJoints, joints.end_v.at);
}

template <class V>
void substep(const RobotModel& model, const RobotParams& params, bool velocity_mode,
             double* vectors) {
  substep_with<V>(model, params, velocity_mode, vectors,
                  [](const LinkFrames<V>&, const JointSolver<V>&) { return NoContacts<V>{}; });
}

template <class V>
void forward_kinematics(const RobotModel& model, double* vectors) {
  V q[kArmJoints];
  load_vectors<V>(vectors, LaneVectors::kQ, kArmJoints, q);
  const TcpPose<V> pose = arm_forward_kinematics<V>(model.single, q, nullptr);
  for (int i = 0; i < 3; ++i) {
    store_doubles<V>(vectors, LaneVectors::kTcp + i,
                     simd::to_doubles(pose.pos[i]) + model.base_position[i]);
  }
  const V quat[4] = {pose.quat.w, pose.quat.x, pose.quat.y, pose.quat.z};
  store_vectors(vectors, LaneVectors::kTcp + 3, 4, quat);
}

template <class V>
unsigned differential_ik(const RobotModel& model, double* vectors) {
  V q[kArmJoints];
  V displacement[6];
  V step[kArmJoints];
  load_vectors<V>(vectors, LaneVectors::kQ, kArmJoints, q);
  load_vectors<V>(vectors, LaneVectors::kDisplacement, 6, displacement);
  TcpJacobian<V> jacobian;
  arm_forward_kinematics<V>(model.single, q, &jacobian);
  const auto well_conditioned = minimum_norm_step(jacobian, displacement, step);
  store_vectors(vectors, LaneVectors::kStep, kArmJoints, step);
  for (int i = 0; i < kArmJoints; ++i) {
    store_vectors(vectors, LaneVectors::kJacobian + 6 * i, 6, jacobian.column[i]);
  }
  return other_lanes<V>(well_conditioned);
}

template <class V>
constexpr LaneKernel make_lane_kernel(InstructionSet set) {
  return {set,        simd::kLanesOf<V>,     clearance_exceeded<V>, pose_links<V>,
          substep<V>, forward_kinematics<V>, differential_ik<V>};
}

}  // namespace ENGRAM_ISA
}  // namespace engram
