// Forward kinematics of a compiled scene: poses bodies and geoms of the robot from the poses of its
// links, and props from their coordinates.
#pragma once

#include <mujoco/mujoco.h>

#include <vector>

#include "core/robot/robot_pose.h"

namespace engram {

class SceneKinematics {
 public:
  SceneKinematics() = default;
  // The model must outlive this object.
  explicit SceneKinematics(const mjModel& model);

  // Poses static bodies, once for new data.
  void pose_fixed(mjData& data) const;
  // Poses all other bodies, as mj_kinematics does, except joint frames of props, anchors of slide
  // joints, sites and lights.
  void pose(const RobotPose& robot, mjData& data) const;

 private:
  struct RobotBody {
    int body = 0;
    Attachment attachment;
    Frame center;  // centre of mass and principal axes, in the body's frame
  };
  struct Geom {
    int geom = 0;
    Frame frame;  // in the body's
  };

  void pose_robot(const RobotPose& robot, mjData& data) const;
  void pose_prop(int body, mjData& data) const;
  void set_body(int body, const Frame& frame, mjData& data) const;

  const mjModel* model_ = nullptr;
  std::vector<RobotBody> robot_;
  std::vector<int> props_;                // bodies
  std::vector<std::vector<Geom>> geoms_;  // of each body
};

}  // namespace engram
