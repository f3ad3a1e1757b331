// Where one robot's moving links are, and what is fixed to which of them.
#pragma once

#include <mujoco/mujoco.h>

#include <array>

#include "core/math/frame.h"
#include "core/robot/drive.h"
#include "core/robot/robot_model.h"

namespace engram {

struct RobotPose {
  JointArray qpos{};                      // rad, m
  std::array<Frame, kRobotJoints> links;  // world: the arm's, then the fingers
};

// From a lane of a block's memory (see LaneRows), after a substep with details; or from joint
// positions alone.
RobotPose pose_in_lane(const RobotModel& chain, const double* rows, int lanes, int lane);
RobotPose pose_at(const RobotModel& chain, const double* qpos);

// A body's place in the frame of the link that carries it.
struct Attachment {
  int link = -1;  // index of the joint that moves it; -1: none does, the frame is the world's
  Frame frame;
};
Attachment attachment_of(const mjModel& model, int body);

// Where a frame that is fixed to a link is in the world.
Frame carried(const RobotPose& pose, const Attachment& attachment);

}  // namespace engram
