// Advances environments by control steps. MuJoCo's data belong to worker threads, not to
// environments: an environment's state lives in columns, and every step loads, computes and stores
// it. So the data stay in the cache, an environment costs a few kilobytes instead of hundreds, and
// a step that diverges is simply not stored.
//
// Robots move side by side, one in each lane of the processor's vectors (lane_kernel.h), whatever
// their scenes are. What else there is, each environment computes by itself. Work that provably has
// no effect is left out:
//  * While nothing at all can touch a robot, and no prop moves, the lane is all there is.
//  * Props that rest are asleep. They wake in the very substep in which something that moves comes
//    within reach of their bounding spheres; in the very step in which a kinematic prop glides by.
//  * Each substep runs on the smallest compiled scene that has room for what is awake.
//
// Simulator::step is the way of one step; SceneBinding, SleepManager and Stepper are its parts.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/base/step_clock.h"
#include "core/robot/lane_kernel.h"
#include "core/robot/robot_params.h"
#include "core/scene/robot_bounds.h"
#include "core/sim/state.h"

namespace engram {

class LaneBlock;
class PhysicsModel;

struct SimulatorOptions {
  int substeps = 5;   // of 0.01 s per control step
  bool sleep = true;  // false: the whole scene, every present prop awake
  int lanes = 0;      // robots side by side: 1, 2, 4, 8; 0: as many as the processor has room for
};

class Simulator {
 public:
  // One workspace for each of `workers` threads. `model` must outlive this object. Throws Error if
  // the processor has no vectors of so many lanes.
  Simulator(const PhysicsModel& model, const SimulatorOptions& options, int workers, int num_envs);
  Simulator(const Simulator&) = delete;
  Simulator& operator=(const Simulator&) = delete;
  ~Simulator();

  // At most so many environments step at once.
  int lanes() const { return kernel_.lanes; }
  // Memory of a worker's lanes, free between two calls of step.
  LaneBlock& block(int worker);

  // One control step of the environments from `first` on, one for each of the drives, at most
  // lanes(), on the workspace of `worker`. Their drives must agree in their mode. Tells which were
  // good; the state of the others, whose physics diverged (non-finite or huge values, or an error
  // of MuJoCo), stays as it was. `clock` may be null.
  void step(const State& state, int first, int worker, std::span<const DriveTarget> drives,
            bool* good, StepClock::Worker* clock = nullptr);
  // The same for one.
  bool step(const State& state, int env, int worker, const DriveTarget& drive,
            StepClock::Worker* clock = nullptr);

  // Recomputes the TCP poses of so many environments, at most lanes(), from their joint positions.
  void update_tcp(const State& state, int first, int count, int worker);

 private:
  struct Lane;       // one environment on its way through a step
  struct Workspace;  // what one worker computes on; nothing in it outlives a step

  void begin_lane(Workspace& workspace, int lane);
  void substep(Workspace& workspace, int count, bool last, bool velocity_mode,
               StepClock::Worker* clock);
  void finish_lane(Workspace& workspace, int lane, StepClock::Worker* clock);

  const PhysicsModel& model_;
  SimulatorOptions options_;
  const LaneKernel& kernel_;
  std::vector<Workspace> workbenches_;
  // Of each environment's robot, as last found. Not part of the state: it holds the joint angles
  // that it was found at, and so stays true after a reset or a restored snapshot.
  std::vector<RobotBounds::Clearance> clearances_;
};

}  // namespace engram
