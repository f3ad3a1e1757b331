// Advances environments by control steps. MuJoCo's data are workbenches, one per worker: an
// environment's state lives in columns, is loaded, stepped and stored again. That keeps the
// workbench in the cache, costs a few kilobytes per environment instead of hundreds, and makes
// "a bad step changes nothing" a matter of not storing.
//
// Work that provably has no effect is left out:
//  * Props that rest are asleep. They wake in the very substep in which something that moves comes
//    within reach of their bounding spheres; in the very step in which a kinematic prop glides by.
//  * Each substep runs on the smallest compiled scene that has room for what is awake.
//  * While nothing at all can touch the robot, its dynamics runs without any geometry.
#pragma once

#include <array>
#include <vector>

#include "core/base/step_clock.h"
#include "core/physics/model.h"
#include "core/physics/pair_sieve.h"
#include "core/physics/state.h"

namespace engram {

// What the drives of the nine joints follow during one control step (common 2.1).
struct Drive {
  std::array<double, kRobotJoints> target{};  // rad, m
  std::array<double, kArmJoints> velocity{};  // rad/s, added through the damping
  bool velocity_mode = false;                 // arm: no stiffness, velocity target only
};

// Sets the controls of a scene's nine motors to what the drive law gives at the present state.
void apply_drive(const DriveLaw& law, const Drive& drive, mjData& data);

struct PhysicsOptions {
  int substeps = 5;   // of 0.01 s per control step
  bool sleep = true;  // false: plain mj_step on the whole scene, every present prop awake
};

class Physics {
 public:
  // One workbench for each of `workers` threads. `model` must outlive this object.
  Physics(const PhysicsModel& model, const PhysicsOptions& options, int workers, int num_envs);

  // One control step of environment `env` on the workbench of `worker`. Returns false, and leaves
  // the state as it was, if physics diverged (non-finite or huge values, or an error of MuJoCo).
  // `clock` may be null.
  bool step(const State& state, int env, int worker, const Drive& drive,
            StepClock::Worker* clock = nullptr);

  // Recomputes the TCP pose from the joint angles.
  void update_tcp(const State& state, int env) const;

  const PhysicsModel& model() const { return model_; }
  const PhysicsOptions& options() const { return options_; }

 private:
  // State of a prop between two scenes; of a kinematic one, its position alone.
  struct PropMotion {
    double qpos[7];
    double qvel[6];
    double qacc_warmstart[6];
  };
  // What one worker computes on; nothing in it outlives a step.
  struct Workbench {
    std::vector<DataPtr> scenes;       // an mjData for every compiled scene
    std::vector<std::uint8_t> status;  // PropStatus while a step is under way
    std::vector<int> slot;             // of each awake prop in the present scene
    std::vector<int> awake_by_type;
    std::vector<PropMotion> motion;                // of awake props
    std::vector<PairSieve> sieves;                 // for every compiled scene
    std::vector<Frame> frames;                     // of props, world; see frame_known
    std::vector<std::uint8_t> frame_known;         // those of resting props come when needed
    std::vector<Eigen::Vector3d> centers;          // of their bounding spheres, world
    std::vector<RobotBounds::Obstacle> obstacles;  // props that are present
    std::vector<double> beyond;                    // from the robot's reach to sleeping props, m
    std::vector<int> gliding;                      // kinematic props on their way
  };
  class Step;  // one control step under way (physics_step.h)

  const PhysicsModel& model_;
  PhysicsOptions options_;
  std::vector<Workbench> workbenches_;
  // Of each environment's robot, as last found. No part of the state: it is a fact about the qpos
  // that it comes with, wherever the robot is by now.
  std::vector<RobotBounds::Clearance> clearances_;
};

}  // namespace engram
