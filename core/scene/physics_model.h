// One task's compiled scene. All environments and threads share it; nothing is written after
// construction.
#pragma once

#include <string>
#include <vector>

#include "core/robot/arm.h"
#include "core/robot/robot_model.h"
#include "core/scene/collision_scene.h"
#include "core/scene/free_body.h"
#include "core/scene/mujoco_handle.h"
#include "core/scene/proximity.h"
#include "core/scene/robot_bounds.h"
#include "core/scene/scene_spec.h"

namespace engram {

// Physical constants of a prop.
struct PropModel {
  std::string name;
  bool free = false;                // moved by physics; otherwise a mocap body, moved by the task
  FreeBody body;                    // of a free one
  double mass = 0;                  // kg
  Eigen::Vector3d bounding_center;  // body frame
  double bounding_radius = 0;       // of a sphere around everything that collides; 0: nothing does
  std::vector<RoundedBox> parts;    // one around each geom that collides, body frame

  // Tests for a prop that physics simulates; other props appear in images only.
  bool tangible() const { return free || bounding_radius > 0; }
};

class PhysicsModel {
 public:
  // Throws Error if a text is refused or lacks what the engine needs.
  explicit PhysicsModel(const SceneSpec& source);

  // Compiled models of the whole scene and of robot and table alone, without gravity and drives:
  // the engine has its own (core/robot/joint_solver.h).
  const mjModel& full() const { return *full_; }
  const mjModel& robot() const { return *robot_; }
  const CollisionScene& collision() const { return collision_; }

  const Arm& arm() const { return arm_; }
  const std::vector<PropModel>& props() const { return props_; }
  const RobotBounds& robot_bounds() const { return robot_bounds_; }
  // The robot's shapes that can touch props, of the CollisionScene, and boxes around them in their
  // own frames.
  const std::vector<int>& reach_shapes() const { return reach_shapes_; }
  const std::vector<RoundedBox>& reach_boxes() const { return reach_boxes_; }
  // Lower and upper limits of the nine robot joints, (9, 2).
  const double* joint_ranges() const { return full().jnt_range; }
  // Constants of the robot's joints and drives, from the text.
  const RobotParams& robot_params() const { return robot_params_; }
  const RobotModel& robot_model() const { return robot_model_; }
  // Weight of one kilogram, N.
  double gravity() const { return gravity_; }

 private:
  void read_props(const SceneSpec& source);
  void find_reach_shapes();

  ModelPtr full_;
  ModelPtr robot_;
  Arm arm_;
  double gravity_ = 0;
  RobotParams robot_params_;
  RobotModel robot_model_;
  CollisionScene collision_;
  std::vector<PropModel> props_;
  RobotBounds robot_bounds_;
  std::vector<int> reach_shapes_;
  std::vector<RoundedBox> reach_boxes_;
};

}  // namespace engram
