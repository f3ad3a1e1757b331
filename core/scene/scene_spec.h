// What a task tells the engine of its scene.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

namespace engram {

// How much of the robot a text describes.
enum class RobotDetail {
  kDynamics,   // bodies, joints and drives, but nothing that collides
  kCollision,  // the same with table, collision geometry and contact pairs
};

// MJCF texts on demand. The robot's bodies, joints, collision geometry and drives come first and
// are the same in all of them.
struct SceneSpec {
  std::vector<std::string> props;  // body names, in the order in which tasks index them
  // Free props of the same type differ in name and looks only, so that they can stand in for one
  // another in the physics of a scene. One number per prop.
  std::vector<int> types;
  // The text for robot, table and the props of these indices (ascending).
  std::function<std::string(std::span<const int> props, RobotDetail detail)> compose;
};

}  // namespace engram
