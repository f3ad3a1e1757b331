// Advances environments by control steps. Working memory belongs to worker threads, not to
// environments: an environment's state lives in columns, and every step loads, simulates and stores
// it. So working memory stays in the cache, an environment costs a few kilobytes, and a step that
// diverges is simply not stored.
//
// Environments move side by side, one in each lane of the processor's vectors: robots
// (lane_kernel.h), and where something touches, contacts and free props as well
// (contact_kernel.h). Pairs of shapes near each other are found side by side, too, their contacts
// for each environment by itself. Work that provably has no effect is left out:
//  * While nothing at all can touch a robot, and no prop moves, the robot is the whole simulation.
//  * Props at rest are asleep (sleep_manager.h). They wake in the very substep in which something
//    that moves comes near their parts; beside a moving kinematic prop, in the very step.
//
// Simulator::step is the sequence of one step: StateTransfer reads the environment, SleepManager
// wakes props, ContactStep finds contacts, and the kernel solves them, all on one EnvStep per lane.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/base/step_clock.h"
#include "core/robot/lane_kernel.h"
#include "core/robot/robot_model.h"
#include "core/scene/robot_bounds.h"
#include "core/sim/physics_engine.h"
#include "core/sim/state.h"

namespace engram {

struct ContactKernel;
struct ContactLanes;

class LaneBlock;
class PhysicsModel;

struct SimulatorOptions {
  int substeps = 5;   // of 0.01 s per control step
  bool sleep = true;  // false: the whole scene, every present prop awake
  int lanes = 0;      // robots side by side: 1, 4, 8, 16; 0: as many as the batch fills
};

class Simulator final : public PhysicsEngine {
 public:
  // One workspace for each of `workers` threads. `model` must outlive this object. Throws Error if
  // the processor has no vectors of that many lanes.
  Simulator(const PhysicsModel& model, const SimulatorOptions& options, int workers, int num_envs);
  ~Simulator() override;

  // Environments that move side by side.
  int lanes() const { return kernel_.lanes; }
  // Memory of a worker's lanes, free between two calls of step.
  LaneBlock& block(int worker);

  // Environments with like contacts move side by side.
  void step(const State& state, int first, int worker, std::span<const DriveTarget> drives,
            bool* ok, StepClock::Worker* clock) override;
  // One control step of one environment.
  bool step(const State& state, int env, int worker, const DriveTarget& drive,
            StepClock::Worker* clock = nullptr);

  // Recomputes the TCP poses of `count` environments from their joint positions.
  void update_tcp(const State& state, int first, int count, int worker);

 private:
  struct Lane;             // one environment's step
  struct WorkerWorkspace;  // working memory of one thread; nothing in it outlives a step

  void sort_by_cost(int first, std::span<int> places) const;
  void step_block(const State& state, int first, std::span<const int> places, int worker,
                  std::span<const DriveTarget> drives, bool* ok, StepClock::Worker* clock);
  void begin_lane(WorkerWorkspace& workspace, int lane);
  void substep(WorkerWorkspace& workspace, int count, bool last, bool velocity_mode,
               StepClock::Worker* clock);
  bool pose_busy(WorkerWorkspace& workspace, int count);
  const ContactLanes& find_contacts(WorkerWorkspace& workspace, int count);
  void finish_lane(WorkerWorkspace& workspace, int lane);

  const PhysicsModel& model_;
  SimulatorOptions options_;
  const LaneKernel& kernel_;
  const ContactKernel& contact_kernel_;
  std::vector<WorkerWorkspace> workspaces_;
  // Clearance of each environment's robot, as last found. Not part of the state: it holds the joint
  // positions of its measurement, and so stays true after a reset or a restored snapshot.
  std::vector<RobotBounds::Clearance> clearances_;
  // Work of each environment's contacts at the end of its last step: a guess of what comes next.
  // Not part of the state: it decides who moves side by side, which changes no result.
  std::vector<int> costs_;
};

}  // namespace engram
