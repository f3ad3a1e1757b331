// One control step of one environment, under way on a worker's workbench.
#pragma once

#include <algorithm>
#include <optional>

#include "core/physics/simulator.h"

namespace engram {

// Gap below which the robot wakes a sleeping prop. Zero would do: a contact needs touching geoms,
// and the test is made at the configuration that collision is computed for.
inline constexpr double kWakeGap = 0.002;  // m

class Physics::Step {
 public:
  Step(Physics& physics, Workbench& bench, const State& state, int env, const Drive& drive,
       StepClock::Worker* clock)
      : model_(physics.model_),
        options_(physics.options_),
        bench_(bench),
        state_(state),
        env_(env),
        drive_(drive),
        clock_(clock),
        clearance_(physics.clearances_[at(env)]) {}

  bool run();

 private:
  int num_props() const { return state_.num_props; }
  static std::size_t at(int index) { return static_cast<std::size_t>(index); }
  const PropModel& prop_model(int prop) const { return model_.props()[at(prop)]; }
  bool is_status(int prop, PropStatus status) const {
    return bench_.status[at(prop)] == static_cast<std::uint8_t>(status);
  }
  bool is_awake(int prop) const { return is_status(prop, PropStatus::kAwake); }
  const PropSlot& slot_of(int prop) const { return scene_->slots[at(bench_.slot[at(prop)])]; }

  // --- choosing and loading scenes ---

  // Whether what is remembered of robot and props can be computed with; also of props that are left
  // out of physics, whose numbers nothing else would look at.
  bool plausible() const;

  void begin();

  // Counts a prop among the awake ones, with the motion that its environment remembers.
  void prepare_awake(int prop);

  // Loads robot and props into the data of a scene and goes on with that.
  void enter(int scene, const double* qpos, const double* qvel, const double* warmstart);

  // From one scene to another in the middle of a step.
  void move_to(int scene);

  void load_kinematic_props();

  // Awake props take the slots of their types in order; slots that stay empty are parked.
  void load_free_props();

  void load_slot(int slot, const PropMotion& motion) const;

  // Takes the motion of awake props out of the present scene.
  void harvest();

  // --- substeps ---

  // Weight of awake props, at their centres of mass. The robot is weightless.
  void apply_weights() const;
  void limit_spins() const;

  void plain_substep() const;

  void composed_substep();

  // Whether the robot is clear of everything, so that it needs no geometry; its environment
  // remembers that.
  bool robot_is_clear();

  // --- waking and sleeping (physics_wake.cc) ---

  // Wakes sleeping props that the robot or an awake prop could touch, and brings kinematic props
  // into the scene that the robot could touch. True if the scene changed.
  bool wake_what_is_near();

  // Whether the robot is where it wakes a sleeping prop. `lowest` is found when first needed.
  bool robot_reaches(int prop, std::optional<double>& lowest);

  void locate(int prop, const double* pos, const double* quat);

  // Where its environment remembers a prop to be.
  void locate_remembered(int prop);

  const Frame& frame_of(int prop) const;

  // Where awake props are now.
  void locate_awake();

  // Lowest height that a part of the robot may reach: a cheap first test, since props lie low and
  // the robot is above them most of the time.
  double lowest_reach() const;

  // By how much the robot is at least farther from a prop than where it would wake it, m; not above
  // zero where it would.
  double robot_beyond(int prop, double lowest) const;

  bool props_near(int prop, int other) const;

  bool awake_prop_near(int prop) const;

  // Puts props to sleep that have rested long enough beside nothing that moves.
  void put_to_sleep();

  // Awake props near one another count as slow as long as the most restless of them, so that they
  // fall asleep together: one that stayed awake would wake the others. True if a count changed.
  bool share_slow_steps(std::uint8_t* slow) const;

  // --- gliding kinematic props (physics_wake.cc) ---

  // A gliding prop counts with the sphere around its whole way.
  void begin_glide(int prop);

  bool is_gliding(int prop) const {
    return std::find(bench_.gliding.begin(), bench_.gliding.end(), prop) != bench_.gliding.end();
  }

  // Radius of the sphere within which a prop may be during this step.
  double reach_of(int prop) const;

  // Whether a gliding prop comes near a free one.
  bool gliding_near(int prop) const;

  // True if a prop woke.
  bool wake_beside_gliding();

  // Puts gliding props where they are after that part of their way.
  void glide(double part);

  // Gliding props have arrived.
  void store_glides() const;

  // --- storing ---

  void store();

  // Sums the contact forces between each prop and each finger, as the prop exerts them.
  void store_finger_forces() const;

  // The awake prop in a slot, or -1 for one that is parked.
  int prop_in_slot(int slot) const;

  const PhysicsModel& model_;
  const PhysicsOptions& options_;
  Workbench& bench_;
  const State& state_;
  int env_;
  const Drive& drive_;
  StepClock::Worker* clock_;
  RobotBounds::Clearance& clearance_;  // of the robot, when last looked at in kDynamicsScene
  int scene_index_ = 0;
  const SceneModel* scene_ = nullptr;
  mjData* data_ = nullptr;
  bool looked_ = false;  // at the robot's clearance, in this step
  std::array<double, RobotBounds::kMaxJoints> seen_qpos_{};  // when sleeping props were looked at
};

}  // namespace engram
