#include "core/robot/robot_pose.h"

#include "core/robot/lane_kernel.h"
#include "core/robot/robot_dynamics.h"

namespace engram {
namespace {

using Vec3d = Eigen::Vector3d;
using RowMat3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

void place_fingers(const RobotModel& chain, RobotPose& pose) {
  const Frame& last = pose.links[kArmJoints - 1];
  for (std::size_t k = 0; k < kFingers; ++k) {
    const Vec3d way = Eigen::Map<const Vec3d>(chain.finger[k].offset) +
                      pose.qpos[kArmJoints + k] * Eigen::Map<const Vec3d>(chain.slide[k]);
    Frame& finger = pose.links[kArmJoints + k];
    finger.pos = last.pos + last.axes * way;
    finger.axes = last.axes * Eigen::Map<const RowMat3>(chain.finger[k].turn);
  }
}

}  // namespace

RobotPose pose_in_lane(const RobotModel& chain, const double* rows, int lanes, int lane) {
  const auto value = [=](int row) { return rows[row * lanes + lane]; };
  RobotPose pose;
  for (std::size_t i = 0; i < kRobotJoints; ++i) {
    pose.qpos[i] = value(LaneRows::kQ + static_cast<int>(i));
  }
  for (int i = 0; i < kArmJoints; ++i) {
    const int first = LaneRows::kLinks + 12 * i;
    Frame& link = pose.links[static_cast<std::size_t>(i)];
    for (int k = 0; k < 3; ++k) link.pos[k] = value(first + k) + chain.base[k];
    for (int k = 0; k < 9; ++k) link.axes(k / 3, k % 3) = value(first + 3 + k);
  }
  place_fingers(chain, pose);
  return pose;
}

RobotPose pose_at(const RobotModel& chain, const double* qpos) {
  RobotPose pose;
  std::copy_n(qpos, kRobotJoints, pose.qpos.begin());
  LinkPose<double> links[kArmJoints];
  link_poses(chain, qpos, links);
  for (std::size_t i = 0; i < kArmJoints; ++i) {
    const Vec3Of<double>& pos = links[i].pos;
    pose.links[i].pos = Vec3d(pos.x, pos.y, pos.z) + Eigen::Map<const Vec3d>(chain.base);
    pose.links[i].axes = Eigen::Map<const RowMat3>(links[i].axes.at);
  }
  place_fingers(chain, pose);
  return pose;
}

Attachment attachment_of(const mjModel& model, int body) {
  Attachment attachment;
  for (; body > 0; body = model.body_parentid[body]) {
    if (model.body_jntnum[body] > 0) {
      attachment.link = model.body_jntadr[body];
      break;
    }
    const Frame place = make_frame(model.body_pos + 3 * body, model.body_quat + 4 * body);
    attachment.frame.pos = place.pos + place.axes * attachment.frame.pos;
    attachment.frame.axes = place.axes * attachment.frame.axes;
  }
  return attachment;
}

Frame carried(const RobotPose& pose, const Attachment& attachment) {
  if (attachment.link < 0) return attachment.frame;
  const Frame& link = pose.links[static_cast<std::size_t>(attachment.link)];
  return {link.pos + link.axes * attachment.frame.pos, link.axes * attachment.frame.axes};
}

}  // namespace engram
