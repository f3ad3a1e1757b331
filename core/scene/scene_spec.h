// Scene specification that a task gives to the engine.
#pragma once

#include <functional>
#include <numeric>
#include <span>
#include <string>
#include <vector>

namespace engram {

// Detail of the robot in a scene's text.
enum class RobotDetail {
  kDynamics,   // bodies, joints and drives, without collision geometry
  kCollision,  // also table, collision geometry and contact pairs
};

// MJCF texts on demand. The robot's bodies, joints, collision geometry and drives come first and
// are the same in all texts.
struct SceneSpec {
  std::vector<std::string> props;  // body names, in the order in which tasks index them
  // Composes the text of robot, table and the props of these indices (ascending).
  std::function<std::string(std::span<const int> props, RobotDetail detail)> compose;

  // The text with all props, and with what collides.
  std::string compose_all() const {
    std::vector<int> all(props.size());
    std::iota(all.begin(), all.end(), 0);
    return compose(all, RobotDetail::kCollision);
  }
};

}  // namespace engram
