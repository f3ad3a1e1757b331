// MuJoCo's own engine as the physics of a batch: one mjModel, and one mjData for each environment,
// stepped by mj_step. The columns hold the state: every control step loads them into the
// environment's mjData, steps it and stores it, so that tasks, observations and snapshots need not
// know. Beside the shared columns there is one more, the warm start of MuJoCo's solver.
//
// MuJoCo has no weightless bodies. Gravity is off in the model, and a force acts as the weight of
// each free prop that is present. Hidden props wait high above the scene, where nothing is.
// Kinematic props are mocap bodies, which have no velocity in MuJoCo; contacts with one in motion
// are given its velocity before they are solved.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/column.h"
#include "core/base/index.h"
#include "core/scene/mujoco_memory.h"
#include "core/scene/scene_spec.h"
#include "core/sim/physics_engine.h"

namespace engram {

class PhysicsModel;

class MujocoPhysics final : public PhysicsEngine {
 public:
  // `model` is that of the scene and must outlive this object. Adds a column to `memory`. Throws
  // Error if memory runs out.
  MujocoPhysics(const SceneSpec& scene, const PhysicsModel& model, int substeps, int workers,
                int num_envs, ColumnStore& memory);

  void step(const State& state, int first, int worker, std::span<const DriveTarget> drives,
            bool* ok, StepClock::Worker* clock) override;

  // For code that is written for MuJoCo: the model, and an environment's data, brought up to its
  // state by mj_forward. Steps do not depend on it. Throws Error if MuJoCo fails.
  const mjModel& model() const { return *mujoco_; }
  const mjData& current_data(const State& state, int env);
  // Memory that an environment's mjData takes up now, the mean of all.
  std::size_t bytes_per_env() const;

 private:
  // Places of a prop in the model.
  struct PropPlace {
    int body = -1;
    int mocap = -1;  // of a kinematic prop
    int qpos = -1;   // of a free one
    int dof = -1;
    double weight = 0;  // N
  };

  bool step_env(const State& state, int env, int worker, const DriveTarget& drive);
  void load(const State& state, int env, mjData& data) const;
  void load_prop(const State& state, int env, int prop, mjData& data) const;
  void move_kinematic_props(const State& state, int env, int substep, mjData& data) const;
  bool is_moving(const State& state, int env, int prop) const;
  void pass_on_kinematic_velocities(const State& state, int env, mjData& data) const;
  void apply_drive(const DriveTarget& drive, mjData& data) const;
  void store(const State& state, int env, const mjData& data) const;
  void store_finger_forces(const State& state, int env, const mjData& data) const;

  int substeps_;
  DriveParams drive_;
  ModelPtr mujoco_;
  std::vector<PropPlace> props_;
  std::vector<int> prop_of_body_;            // -1: none
  std::vector<int> finger_of_body_;          // -1: none
  std::vector<DataPtr> data_;                // of each environment
  std::vector<MujocoWorkspace> workspaces_;  // of each worker
  Column<double> warm_start_;                // (nv) qacc_warmstart
};

}  // namespace engram
