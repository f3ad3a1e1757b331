// Interface of the two physics: engram's own (simulator.h) and MuJoCo's (mujoco_physics.h).
#pragma once

#include <span>

#include "core/base/step_clock.h"
#include "core/robot/robot_model.h"
#include "core/sim/state.h"

namespace engram {

class PhysicsEngine {
 public:
  PhysicsEngine() = default;
  PhysicsEngine(const PhysicsEngine&) = delete;
  PhysicsEngine& operator=(const PhysicsEngine&) = delete;
  virtual ~PhysicsEngine() = default;

  // Most environments of one call of step.
  static constexpr int kMaxTogether = 128;

  // One control step of the environments from `first` on, one for each of the drives, at most
  // kMaxTogether, on the workspace of `worker`. Their drives must agree in their mode. Sets `ok` of
  // each environment; false: its physics diverged (non-finite or huge values, or an error or
  // warning of MuJoCo), and its state stays as it was. `clock` may be null.
  virtual void step(const State& state, int first, int worker, std::span<const DriveTarget> drives,
                    bool* ok, StepClock::Worker* clock) = 0;
};

}  // namespace engram
