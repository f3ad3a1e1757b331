// Advances environments by control steps. MuJoCo's data belong to worker threads, not to
// environments: an environment's state lives in columns, and every step loads, computes and stores
// it. So the data stay in the cache, an environment costs a few kilobytes instead of hundreds, and
// a step that diverges is simply not stored.
//
// Work that provably has no effect is left out:
//  * Props that rest are asleep. They wake in the very substep in which something that moves comes
//    within reach of their bounding spheres; in the very step in which a kinematic prop glides by.
//  * Each substep runs on the smallest compiled scene that has room for what is awake.
//  * While nothing at all can touch the robot, its dynamics runs without any geometry.
//
// Simulator::advance is the way of one step; Loader, Waker and Stepper are its parts.
#pragma once

#include <vector>

#include "core/base/step_clock.h"
#include "core/physics/drive.h"
#include "core/physics/robot_bounds.h"
#include "core/physics/state.h"

namespace engram {

class PhysicsModel;

struct SimulatorOptions {
  int substeps = 5;   // of 0.01 s per control step
  bool sleep = true;  // false: the whole scene, every present prop awake
};

class Simulator {
 public:
  // One workbench for each of `workers` threads. `model` must outlive this object.
  Simulator(const PhysicsModel& model, const SimulatorOptions& options, int workers, int num_envs);
  Simulator(const Simulator&) = delete;
  Simulator& operator=(const Simulator&) = delete;
  ~Simulator();

  // One control step of environment `env` on the workbench of `worker`. Returns false, and leaves
  // the state as it was, if physics diverged (non-finite or huge values, or an error of MuJoCo).
  // `clock` may be null.
  bool step(const State& state, int env, int worker, const Drive& drive,
            StepClock::Worker* clock = nullptr);

  // Recomputes the TCP pose from the joint angles.
  void update_tcp(const State& state, int env) const;

 private:
  struct Workbench;  // what one worker computes on; nothing in it outlives a step

  bool advance(Workbench& workbench, const State& state, int env, const Drive& drive,
               StepClock::Worker* clock);

  const PhysicsModel& model_;
  SimulatorOptions options_;
  std::vector<Workbench> workbenches_;
  // Of each environment's robot, as last found. Not part of the state: it holds the joint angles
  // that it was found at, and so stays true after a reset or a restored snapshot.
  std::vector<RobotBounds::Clearance> clearances_;
};

}  // namespace engram
