// The physics of one environment, as a batch has it.
#pragma once

#include <memory>

#include "core/batch/options.h"
#include "core/scene/physics_model.h"
#include "core/scene/scene_spec.h"
#include "core/sim/mujoco_physics.h"
#include "core/sim/simulator.h"

namespace engram::test {

// Five substeps in a control step. Scene, model and columns must outlive it.
inline std::unique_ptr<PhysicsEngine> make_engine(Physics physics, const SceneSpec& scene,
                                                  const PhysicsModel& model, ColumnStore& store) {
  constexpr int kSubsteps = 5;
  if (physics == Physics::kMujoco) {
    return std::make_unique<MujocoPhysics>(scene, model, kSubsteps, 1, 1, store);
  }
  return std::make_unique<Simulator>(model, SimulatorOptions{kSubsteps}, 1, 1);
}

}  // namespace engram::test
