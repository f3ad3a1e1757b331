// The kernel of one width, compiled for one instruction set.
#pragma once

#include "core/robot/arm_kinematics.h"
#include "core/robot/lane_kernel.h"
#include "core/robot/robot_dynamics.h"

namespace engram {
inline namespace ENGRAM_LANES {

template <class V>
unsigned moved_far(const RobotModel& chain, const double* rows) {
  V way = {};
  for (int i = 0; i < kRobotJoints; ++i) {
    way += chain.arms[i] *
           magnitude(row<V>(rows, LaneRows::kQ + i) - row<V>(rows, LaneRows::kSeen + i));
  }
  const unsigned all = (1U << kLanesOf<V>)-1;
  return all & ~bits_of(way < row<V>(rows, LaneRows::kRoom));
}

template <class V>
void load_joints(const double* rows, int first, V* to) {
  for (int i = 0; i < kRobotJoints; ++i) to[i] = row<V>(rows, first + i);
}
template <class V>
void store_joints(double* rows, int first, const V* from) {
  for (int i = 0; i < kRobotJoints; ++i) set_row(rows, first + i, from[i]);
}

template <class V>
void store_details(const JointSolver<V>& joints, const LinkPose<V>* links, double* rows) {
  store_joints(rows, LaneRows::kBias, joints.bias.at);
  for (int i = 0; i < kRobotJoints; ++i) {
    store_joints(rows, LaneRows::kInertia + i * kRobotJoints, joints.w[i].at);
  }
  for (int i = 0; i < kArmJoints; ++i) {
    const int first = LaneRows::kLinks + 12 * i;
    set_row(rows, first, links[i].pos.x);
    set_row(rows, first + 1, links[i].pos.y);
    set_row(rows, first + 2, links[i].pos.z);
    for (int k = 0; k < 9; ++k) set_row(rows, first + 3 + k, links[i].axes.at[k]);
  }
}

template <class V>
void substep(const RobotModel& chain, const RobotParams& law, bool velocity_mode, double* rows,
             bool details) {
  JointSolver<V> joints;
  load_joints<V>(rows, LaneRows::kQ, joints.end_q.at);
  load_joints<V>(rows, LaneRows::kV, joints.begin_v.at);
  load_joints<V>(rows, LaneRows::kAim, joints.aim.at);
  LinkPose<V> links[kArmJoints];
  link_poses<V>(chain, joints.end_q.at, links);
  {
    const RobotDynamics<V> dynamics(chain, joints.end_q.at, links);
    dynamics.inertia(joints.w);
    dynamics.bias(joints.begin_v.at, joints.bias.at);
  }
  if (details) store_details<V>(joints, links, rows);
  for (int i = 0; i < kRobotJoints; ++i) {
    joints.stiffness[i] = velocity_mode && i < kArmJoints ? 0.0 : law.drive.stiffness;
  }
  joints.prepare(law);
  joints.run(law, nullptr, nullptr);
  store_joints(rows, LaneRows::kEndQ, joints.end_q.at);
  store_joints(rows, LaneRows::kEndV, joints.end_v.at);
}

template <class V>
void tool(const RobotModel& chain, double* rows) {
  V q[kArmJoints];
  for (int i = 0; i < kArmJoints; ++i) q[i] = row<V>(rows, LaneRows::kQ + i);
  const ToolPose<V> pose = arm_forward_kinematics<V>(chain, q, nullptr);
  set_row(rows, LaneRows::kTcp, pose.pos.x + chain.base[0]);
  set_row(rows, LaneRows::kTcp + 1, pose.pos.y + chain.base[1]);
  set_row(rows, LaneRows::kTcp + 2, pose.pos.z + chain.base[2]);
  set_row(rows, LaneRows::kTcp + 3, pose.quat.w);
  set_row(rows, LaneRows::kTcp + 4, pose.quat.x);
  set_row(rows, LaneRows::kTcp + 5, pose.quat.y);
  set_row(rows, LaneRows::kTcp + 6, pose.quat.z);
}

template <class V>
unsigned reach(const RobotModel& chain, double* rows) {
  V q[kArmJoints];
  V twist[6];
  V step[kArmJoints];
  for (int i = 0; i < kArmJoints; ++i) q[i] = row<V>(rows, LaneRows::kQ + i);
  for (int i = 0; i < 6; ++i) twist[i] = row<V>(rows, LaneRows::kTwist + i);
  ToolJacobian<V> jacobian;
  arm_forward_kinematics<V>(chain, q, &jacobian);
  const auto well = minimum_norm_step(jacobian, twist, step);
  for (int i = 0; i < kArmJoints; ++i) {
    set_row(rows, LaneRows::kStep + i, step[i]);
    for (int k = 0; k < 6; ++k) {
      set_row(rows, LaneRows::kJacobian + 6 * i + k, jacobian.column[i][k]);
    }
  }
  const unsigned all = (1U << kLanesOf<V>)-1;
  return all & ~bits_of(well);
}

template <class V>
constexpr LaneKernel make_lane_kernel(const char* name) {
  return {name, kLanesOf<V>, moved_far<V>, substep<V>, tool<V>, reach<V>};
}

}  // namespace ENGRAM_LANES
}  // namespace engram
