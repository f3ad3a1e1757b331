// One task's scene, compiled in several sizes. All environments and threads share it; nothing is
// written after construction.
#pragma once

#include <string>
#include <vector>

#include "core/robot/arm.h"
#include "core/robot/robot_params.h"
#include "core/scene/proximity.h"
#include "core/scene/robot_bounds.h"
#include "core/scene/scene_model.h"

namespace engram {

// Physical constants of a prop.
struct PropModel {
  std::string name;
  int type = 0;
  bool free = false;                // moved by physics; otherwise a mocap body, moved by the task
  double mass = 0;                  // kg
  Eigen::Vector3d center_of_mass;   // body frame
  Eigen::Vector3d bounding_center;  // body frame
  double bounding_radius = 0;       // of a sphere around everything that collides; 0: nothing does
  std::vector<RoundedBox> parts;    // one around each geom that collides, body frame

  // Tests for a prop that physics simulates; other props appear in pictures only.
  bool tangible() const { return free || bounding_radius > 0; }
};

class PhysicsModel {
 public:
  // Throws Error if a text is refused or lacks what the engine needs.
  explicit PhysicsModel(const SceneSpec& source);

  // Scenes in ascending order: the robot's dynamics without geometry; robot and table; then robot,
  // table and more and more props.
  const std::vector<SceneModel>& scenes() const { return scenes_; }
  static constexpr int kDynamicsScene = 0;
  static constexpr int kRobotScene = 1;
  int full_scene() const { return static_cast<int>(scenes_.size()) - 1; }
  // Smallest scene, from kRobotScene on, with slots for awake props, counted by type, and with the
  // kinematic props if they are needed.
  int smallest_scene(std::span<const int> count_by_type, bool kinematic_props) const;

  // Models of the whole scene and of robot and table alone.
  const mjModel& full() const { return *scenes_.back().model; }
  const mjModel& robot() const { return *scenes_[kRobotScene].model; }

  const Arm& arm() const { return arm_; }
  const std::vector<PropModel>& props() const { return props_; }
  int num_types() const { return num_types_; }
  const RobotBounds& robot_bounds() const { return robot_bounds_; }
  // Robot geoms that can touch props; the same indices in all scenes that have geometry.
  const std::vector<int>& reach_geoms() const { return reach_geoms_; }
  // Boxes around them, in their own frames.
  const std::vector<RoundedBox>& reach_boxes() const { return reach_boxes_; }
  // Bodies of the left and right finger; the same in all scenes.
  const int* finger_bodies() const { return finger_bodies_; }
  // Lower and upper limits of the nine robot joints, (9, 2).
  const double* joint_ranges() const { return full().jnt_range; }
  // Constants of the robot's joints and drives, from the text.
  const RobotParams& robot_params() const { return robot_params_; }
  const RobotModel& robot_model() const { return robot_model_; }
  // Weight of one kilogram, N.
  double gravity() const { return gravity_; }

 private:
  // `whole`: the compiled text of the whole scene.
  PhysicsModel(const SceneSpec& source, ModelPtr whole);
  void read_text_model(const SceneSpec& source, const mjModel& whole);
  void read_props(const SceneSpec& source, const mjModel& whole);
  void find_reach_geoms(const mjModel& whole);

  RobotParams robot_params_;
  RobotModel robot_model_;
  double gravity_ = 0;
  std::vector<PropModel> props_;
  int num_types_ = 0;
  std::vector<SceneModel> scenes_;
  Arm arm_;
  RobotBounds robot_bounds_;
  std::vector<int> reach_geoms_;
  std::vector<RoundedBox> reach_boxes_;
  int finger_bodies_[kFingers] = {-1, -1};
};

}  // namespace engram
