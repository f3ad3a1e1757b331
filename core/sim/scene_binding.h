// Carries one environment from its columns into a compiled scene, from scene to scene, and back.
// Knows which props are awake, which slots they have, and where gliding props are on their way.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/contact/contact_filter.h"
#include "core/scene/physics_model.h"
#include "core/sim/scene_workspace.h"
#include "core/sim/state.h"

namespace engram {

inline std::size_t at(int index) { return static_cast<std::size_t>(index); }

class SceneBinding {
 public:
  // What MuJoCo needs of a free prop; of a kinematic one, position and linear velocity alone.
  struct Motion {
    std::array<double, 7> qpos;
    std::array<double, 6> qvel;
    std::array<double, 6> qacc_warmstart;
  };

  // Working memory of one environment on its way through a step.
  struct Workspace {
    explicit Workspace(const PhysicsModel& model);

    JointArray contact_force{};          // on the robot's joints, in the last substep, N m, N
    std::vector<PropStatus> status;      // of each prop while a step is under way
    std::vector<int> awake_by_type;      // how many
    std::vector<int> slot;               // of each awake prop in the present scene, or kNoSlot
    std::vector<int> prop;               // in each slot of the present scene, or kParked
    std::vector<Motion> motion;          // of awake and gliding props, between scenes
    std::vector<int> gliding;            // kinematic props on their way
    std::vector<KinematicBody> gliders;  // the same, for contacts
  };

  SceneBinding(Workspace& workspace, SceneWorkspace& scenes, const State& state, int env)
      : model_(scenes.model()), workspace_(workspace), scenes_(scenes), state_(state), env_(env) {}

  // --- the way of a step ---

  // Whether all numbers in the columns are finite and not huge. Looks at every prop, also at those
  // that no scene will hold: nothing else would find a bad number there.
  bool state_is_plausible() const;

  // Reads which props are awake and which glide. Without `sleep` every free prop that is present
  // is awake.
  void begin(bool sleep);

  // Makes a scene the present one. Nothing is in it yet.
  void enter(int scene);

  // Loads props, and the robot at these joint positions and velocities, into the present scene;
  // what other environments have left there is gone.
  void load(const JointArray& qpos, const JointArray& qvel);

  // Takes what a substep made of them out again.
  void harvest();
  // Nothing touches the robot in this substep.
  void forget_contacts() { workspace_.contact_force = {}; }

  // Moves gliding props to where they are after so many of the control step's substeps.
  void glide(int substep, int substeps);

  // Those that are in the present scene.
  std::span<const KinematicBody> gliders();

  // Counts a sleeping free prop among the awake ones. It comes into the next scene.
  void wake(int prop);

  // Whether all numbers of the robot and of awake props are finite and not huge.
  bool is_plausible(const JointArray& qpos, const JointArray& qvel) const;

  // Writes robot, props and contact forces into the columns. The present scene must hold the last
  // substep still.
  void store(const JointArray& qpos, const JointArray& qvel);

  // --- props ---

  int num_props() const { return state_.num_props; }
  const PropModel& prop_model(int prop) const { return model_.props()[at(prop)]; }
  bool is_awake(int prop) const { return workspace_.status[at(prop)] == PropStatus::kAwake; }
  bool is_asleep(int prop) const { return workspace_.status[at(prop)] == PropStatus::kAsleep; }
  int num_awake() const { return num_awake_; }
  const std::vector<int>& gliding() const { return workspace_.gliding; }
  bool is_gliding(int prop) const {
    return std::find(gliding().begin(), gliding().end(), prop) != gliding().end();
  }

  // --- the columns: until store() they hold what was before this step ---

  const State& state() const { return state_; }
  int env() const { return env_; }

  // --- the present scene ---

  const PhysicsModel& model() const { return model_; }
  int scene_index() const { return scene_index_; }
  const SceneModel& scene() const { return *scene_; }
  const mjModel& scene_model() const { return *scene_->model; }
  mjData& data() const { return *place_->data; }
  BroadPhase& sieve() const { return place_->sieve; }
  ContactWorkspace& contact_workspace() const { return scenes_.contact_workspace(); }
  // Whether there is more in it than robot and table.
  bool scene_has_props() const { return scene_index_ > PhysicsModel::kRobotScene; }
  // Where an awake prop's coordinates are.
  const PropSlot& slot_of(int prop) const { return scene_->slots[at(workspace_.slot[at(prop)])]; }
  // The smallest scene with room for awake props, and for kinematic ones if they are needed.
  int smallest_scene(bool kinematic_props) const {
    return model_.smallest_scene(workspace_.awake_by_type, kinematic_props);
  }

 private:
  static constexpr int kNoSlot = -1;  // of a prop that woke in this scene
  static constexpr int kParked = -1;  // in a slot: no prop

  void begin_glide(int prop);

  void load_kinematic_props();
  void load_free_props();
  // Awake props take the slots of their types in order; slots that stay empty are parked.
  void assign_slots();
  void load_slot(int slot, const Motion& motion) const;

  void store_gliding_props() const;
  void store_awake_props() const;
  // Sums the contact forces between each prop and each finger, as the prop exerts them.
  void store_finger_forces() const;

  const PhysicsModel& model_;
  Workspace& workspace_;
  SceneWorkspace& scenes_;
  const State& state_;
  int env_;
  int num_awake_ = 0;
  int scene_index_ = 0;
  const SceneModel* scene_ = nullptr;
  SceneWorkspace::Place* place_ = nullptr;
};

}  // namespace engram
