// Carries one environment from its columns into a compiled scene, from scene to scene, and back.
// Knows which props are awake, which slots they have, and where gliding props are on their way.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/physics/contacts.h"
#include "core/physics/model.h"
#include "core/physics/state.h"

namespace engram {

inline std::size_t at(int index) { return static_cast<std::size_t>(index); }

class Loader {
 public:
  // What MuJoCo needs of a free prop; of a kinematic one, position and linear velocity alone.
  struct Motion {
    std::array<double, 7> qpos;
    std::array<double, 6> qvel;
    std::array<double, 6> qacc_warmstart;
  };

  // Working memory of one thread.
  struct Workbench {
    explicit Workbench(const PhysicsModel& model);

    // Makes every mjData as good as new, after a step that diverged.
    void reset_data();

    const PhysicsModel* model;
    std::vector<DataPtr> data;       // for every compiled scene
    std::vector<PropStatus> status;  // of each prop while a step is under way
    std::vector<int> awake_by_type;  // how many
    std::vector<int> slot;           // of each awake prop in the present scene, or kNoSlot
    std::vector<Motion> motion;      // of awake and gliding props, between scenes
    std::vector<int> gliding;        // kinematic props on their way
    std::vector<Glider> gliders;     // the same, for contacts
  };

  Loader(Workbench& workbench, const State& state, int env)
      : model_(*workbench.model), workbench_(workbench), state_(state), env_(env) {}

  // --- the way of a step ---

  // Whether all numbers in the columns are finite and not huge. Looks at every prop, also at those
  // that no scene will hold: nothing else would find a bad number there.
  bool state_is_plausible() const;

  // Reads which props are awake and which glide. Without `sleep` every free prop that is present
  // is awake.
  void begin(bool sleep);

  // Loads robot and props from the columns into a scene, which becomes the present one.
  void enter(int scene);

  // Moves gliding props to where they are after so many of the control step's substeps.
  void glide(int substep, int substeps);

  // Those that are in the present scene.
  std::span<const Glider> gliders();

  // Counts a sleeping free prop among the awake ones. It comes into the next scene.
  void wake(int prop);

  // From the present scene to another one, in the middle of a step.
  void move_to(int scene);

  // Whether all numbers in the present scene are finite and not huge.
  bool scene_is_plausible() const;

  // Writes robot, props and contact forces of the present scene into the columns.
  void store();

  // --- props ---

  int num_props() const { return state_.num_props; }
  const PropModel& prop_model(int prop) const { return model_.props()[at(prop)]; }
  bool is_awake(int prop) const { return workbench_.status[at(prop)] == PropStatus::kAwake; }
  bool is_asleep(int prop) const { return workbench_.status[at(prop)] == PropStatus::kAsleep; }
  int num_awake() const { return num_awake_; }
  const std::vector<int>& gliding() const { return workbench_.gliding; }
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
  mjData& data() const { return *data_; }
  // Whether there is more in it than robot and table.
  bool scene_has_props() const { return scene_index_ > PhysicsModel::kRobotScene; }
  // Where an awake prop's coordinates are.
  const PropSlot& slot_of(int prop) const { return scene_->slots[at(workbench_.slot[at(prop)])]; }
  // The smallest scene with room for awake props, and for kinematic ones if they are needed.
  int smallest_scene(bool kinematic_props) const {
    return model_.smallest_scene(workbench_.awake_by_type, kinematic_props);
  }

 private:
  static constexpr int kNoSlot = -1;  // of a prop that woke in this scene

  void begin_glide(int prop);

  void load(int scene, const double* qpos, const double* qvel, const double* contact_force);
  void load_kinematic_props();
  // Awake props take the slots of their types in order; slots that stay empty are parked.
  void load_free_props();
  void load_slot(int slot, const Motion& motion) const;

  // Takes the motion of awake props out of the present scene.
  void harvest();

  void store_robot() const;
  void store_gliding_props() const;
  void store_awake_props() const;
  // Sums the contact forces between each prop and each finger, as the prop exerts them.
  void store_finger_forces() const;
  // The awake prop in a slot, or -1 for one that is parked.
  int prop_in_slot(int slot) const;

  const PhysicsModel& model_;
  Workbench& workbench_;
  const State& state_;
  int env_;
  int num_awake_ = 0;
  int scene_index_ = 0;
  const SceneModel* scene_ = nullptr;
  mjData* data_ = nullptr;
};

}  // namespace engram
