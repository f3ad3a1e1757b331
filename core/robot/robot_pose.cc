#include "core/robot/robot_pose.h"

#include <algorithm>

#include "core/base/index.h"
#include "core/robot/lane_kernel.h"

namespace engram {
namespace {

void place_fingers(const RobotModel& robot, RobotPose& pose) {
  const Frame& last = pose.links[kArmJoints - 1];
  for (std::size_t k = 0; k < kFingers; ++k) {
    const Vec3 offset = Eigen::Map<const Vec3>(robot.fingers[k].offset) +
                        pose.qpos[kArmJoints + k] * Eigen::Map<const Vec3>(robot.finger_axis[k]);
    Frame& finger = pose.links[kArmJoints + k];
    finger.pos = last.pos + last.axes * offset;
    finger.axes = last.axes * Eigen::Map<const RowMat3>(robot.fingers[k].rotation);
  }
}

}  // namespace

RobotPose pose_in_lane(const RobotModel& robot, const double* vectors, int lanes, int lane) {
  const auto value = [=](int vector) { return vectors[vector * lanes + lane]; };
  RobotPose pose;
  for (std::size_t i = 0; i < kRobotJoints; ++i) {
    pose.qpos[i] = value(LaneVectors::kQ + static_cast<int>(i));
  }
  for (int i = 0; i < kArmJoints; ++i) {
    const int first = LaneVectors::kLinkPoses + 12 * i;
    Frame& link = pose.links[at(i)];
    for (int k = 0; k < 3; ++k) link.pos[k] = value(first + k) + robot.base_position[k];
    for (int k = 0; k < 9; ++k) link.axes(k / 3, k % 3) = value(first + 3 + k);
  }
  place_fingers(robot, pose);
  return pose;
}

RobotPose pose_at(const RobotModel& robot, const double* qpos) {
  std::array<double, LaneVectors::kCount> vectors{};
  std::copy_n(qpos, kRobotJoints, vectors.data() + LaneVectors::kQ);
  lane_kernel(1)->pose_links(robot, vectors.data());
  return pose_in_lane(robot, vectors.data(), 1, 0);
}

Attachment attachment_of(const mjModel& model, int body) {
  Attachment attachment;
  for (; body > 0; body = model.body_parentid[body]) {
    if (model.body_jntnum[body] > 0) {
      attachment.link = model.body_jntadr[body];
      break;
    }
    const Frame local = make_frame(model.body_pos + 3 * body, model.body_quat + 4 * body);
    attachment.frame.pos = local.pos + local.axes * attachment.frame.pos;
    attachment.frame.axes = local.axes * attachment.frame.axes;
  }
  return attachment;
}

Frame carried(const RobotPose& pose, const Attachment& attachment) {
  if (attachment.link < 0) return attachment.frame;
  const Frame& link = pose.links[at(attachment.link)];
  return {link.pos + link.axes * attachment.frame.pos, link.axes * attachment.frame.axes};
}

}  // namespace engram
