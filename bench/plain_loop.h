// The baseline that a user would write: one mjData per environment, mj_step on the whole scene.
#pragma once

#include <vector>

#include "core/batch/batch.h"
#include "core/scene/mujoco_handle.h"

namespace engram::bench {

// Runs the same episodes as a Batch, with the same actions and controller, on the same compiled
// model with drives of MuJoCo's own, and simulates every present prop in every substep. One thread.
class PlainLoop {
 public:
  enum class SceneKind { kFull, kRobotAlone };

  PlainLoop(const Batch& reference, SceneKind kind);

  // Copies the changes that the reference's task has made to the scene since the last step: new
  // episodes, hidden and revealed props. Not timed.
  void sync_scene();
  // One control step of all environments.
  void step(std::span<const float> actions);

 private:
  void load_robot(int env);
  void load_prop(int env, int prop);

  const Batch& reference_;
  ModelPtr model_;
  bool full_;
  Controller controller_;
  ColumnStore store_;
  State state_;  // input of the controller: the plain loop's own joints
  std::vector<DataPtr> data_;
  std::vector<std::uint8_t> shown_;  // (num_envs, num_props) props that are present
};

}  // namespace engram::bench
