// mj_step as MuJoCo's own `testspeed` times it, one mjData on one thread, on the scene and motion
// of a batch with MuJoCo's physics.
#pragma once

#include <vector>

#include "core/batch/batch.h"
#include "core/batch/queries.h"
#include "core/scene/mujoco_handle.h"

namespace engram::bench {

class MjStepLoop {
 public:
  // One task. `batch` must outlive this object.
  explicit MjStepLoop(const Batch& batch);

  // Copies the states of all environments as they are before a step of the batch.
  void note_states();
  // Seconds that mj_step takes for that step of all environments, with the controls that they had
  // in it. Loading is not timed.
  double step_seconds();

 private:
  struct Noted {
    std::vector<mjtNum> qpos, qvel, mocap_pos, mocap_quat, forces, controls;
    std::vector<mjtNum> warm_start;  // of this loop's own last step
  };

  void load(const Noted& noted);

  const Batch& batch_;
  const Queries queries_;
  const mjModel& model_;
  DataPtr data_;
  std::vector<Noted> noted_;  // of each environment
};

}  // namespace engram::bench
