// Transfer of one environment between its columns and compiled scenes: loads the scene in use,
// reads it back after every substep, and stores the result in the columns.
#pragma once

#include <span>
#include <vector>

#include "core/contact/contact_step.h"
#include "core/sim/env_step.h"

namespace engram {

// Scenes of one thread: data of every compiled scene, and the memory of the contact solver.
class SceneWorkspace {
 public:
  explicit SceneWorkspace(const PhysicsModel& model);

  SceneInstance& instance(int scene) { return instances_[at(scene)]; }
  ContactWorkspace& contact_workspace() { return contact_workspace_; }

  // Resets all data after a step that diverged.
  void reset_data();

 private:
  const PhysicsModel* model_;
  std::vector<SceneInstance> instances_;  // of every compiled scene
  ContactWorkspace contact_workspace_;
};

class SceneBinding {
 public:
  SceneBinding(EnvStep& step, SceneWorkspace& scenes)
      : step_(step),
        workspace_(step.workspace),
        scenes_(scenes),
        state_(step.state),
        env_(step.env) {}

  // Tests that all numbers in the columns are finite and not huge. Checks every prop, also those
  // that no scene will hold: no other check would find a bad number there.
  bool state_is_plausible() const;

  // Reads contact forces, and which props are awake or in motion. Without `sleep` every free prop
  // that is present is awake.
  void begin(bool sleep);

  // Makes a scene the one in use, without loading it.
  void select_scene(int scene);

  // Loads props, and the robot at these joint positions and velocities, into the scene in use,
  // overwriting the state of other environments.
  void load(const JointArray& qpos, const JointArray& qvel);

  // Reads the motion of awake props back after a substep.
  void read_back();

  // Moves kinematic props in motion to their positions after so many of the control step's
  // substeps.
  void move_kinematic_props(int substep, int substeps);

  // Moving kinematic bodies of the scene in use.
  std::span<const KinematicBody> kinematic_bodies();

  // Tests that all numbers of the robot and of awake props are finite and not huge.
  bool is_plausible(const JointArray& qpos, const JointArray& qvel) const;

  // Writes robot, props and contact forces into the columns. The scene in use must still hold the
  // last substep.
  void store(const JointArray& qpos, const JointArray& qvel);

 private:
  void begin_kinematic_motion(int prop);

  void load_kinematic_props();
  void load_free_props();
  // Assigns slots to awake props of their types, in order; empty slots hold kNoProp.
  void assign_slots();
  void load_slot(int slot, const PropMotion& motion) const;

  void store_moving_props() const;
  void store_awake_props() const;
  // Sums the contact forces that each prop exerts on each finger.
  void store_finger_forces() const;

  EnvStep& step_;
  StepWorkspace& workspace_;
  SceneWorkspace& scenes_;
  const State& state_;
  int env_;
};

}  // namespace engram
