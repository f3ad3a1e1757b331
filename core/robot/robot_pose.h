// Poses of one robot's moving links in the world, and of frames that are fixed to them.
#pragma once

#include <mujoco/mujoco.h>

#include <array>

#include "core/math/frame.h"
#include "core/robot/robot_model.h"

namespace engram {

struct RobotPose {
  JointArray qpos{};                      // rad, m
  std::array<Frame, kRobotJoints> links;  // world: the arm's, then the fingers
};

// Pose from a lane of a block's memory (see LaneVectors), after a substep with details; or from
// joint positions alone.
RobotPose pose_in_lane(const RobotModel& robot, const double* vectors, int lanes, int lane);
RobotPose pose_at(const RobotModel& robot, const double* qpos);

// Frame of a body in that of the link that carries it.
struct Attachment {
  int link = -1;  // index of the joint that moves it; -1: none does, the frame is the world's
  Frame frame;
};
Attachment attachment_of(const mjModel& model, int body);

// A frame that is fixed to a link, in the world.
Frame carried(const RobotPose& pose, const Attachment& attachment);

}  // namespace engram
