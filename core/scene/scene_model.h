// A compiled scene with slots for some of a task's props.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/scene/free_body.h"
#include "core/scene/mujoco_handle.h"
#include "core/scene/scene_kinematics.h"
#include "core/scene/scene_spec.h"

namespace engram {

// Slot for one free prop of a type.
struct PropSlot {
  int type = 0;
  int body = 0;
  int qpos = 0;  // address of seven position coordinates
  int dof = 0;   // address of six velocity coordinates
};

// Never written after construction, so all environments and threads share it. There is no gravity:
// the engine applies the weight of props, and the robot's links are weightless. Drives, limits and
// the coupling of the fingers are the engine's, too (robot_step.h).
struct SceneModel {
  ModelPtr model;
  std::vector<PropSlot> slots;                // in ascending order of type
  std::vector<FreeBody> free_bodies;          // of the slots
  std::vector<int> slot_of_body;              // or -1
  std::vector<std::uint16_t> joints_of_body;  // the robot's joints that move it, as bits
  std::vector<int> mocap;                     // of each prop of the task: its mocap body, or -1
  bool has_kinematic_props = false;
  SceneKinematics kinematics;

  // Tests for a slot for each of these awake props, counted by type.
  bool has_slots_for(std::span<const int> count_by_type) const;
};

// Compiles a scene with the props of these indices. Throws Error if the text is refused or
// contact_step cannot simulate it.
SceneModel compile_scene(const SceneSpec& source, std::span<const int> props, RobotDetail detail);
// Makes it from its compiled text.
SceneModel make_scene(ModelPtr compiled, const SceneSpec& source, std::span<const int> props);

// Subsets of free props, by index, for which smaller scenes are compiled: all combinations of types
// with 1 to 4 props, then with some larger numbers of props, up to `limit` subsets.
std::vector<std::vector<int>> scene_subsets(const SceneSpec& source,
                                            std::span<const int> free_props, std::size_t limit);

}  // namespace engram
