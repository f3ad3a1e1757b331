// Context of one environment's control step. SceneBinding, SleepManager and Simulator work on it
// side by side; it holds what they share: the environment's columns, the scene in use, and the
// state of props while the step is under way.
#pragma once

#include <algorithm>
#include <array>
#include <vector>

#include "core/base/index.h"
#include "core/base/step_clock.h"
#include "core/contact/broad_phase.h"
#include "core/contact/contact_filter.h"
#include "core/scene/physics_model.h"
#include "core/sim/state.h"

namespace engram {

// State of a free prop in MuJoCo's layout; of a kinematic one, position and linear velocity alone.
struct PropMotion {
  std::array<double, 7> qpos;
  std::array<double, 6> qvel;
  std::array<double, 6> qacc_warmstart;
};

// Data of one compiled scene on one thread. Environments that step side by side take turns.
struct SceneInstance {
  DataPtr data;
  BroadPhase broad_phase;
  const void* owner = nullptr;  // workspace of the environment whose props are loaded
};

// Working memory of one environment's step. Lanes reuse it, so that steps do not allocate.
struct StepWorkspace {
  explicit StepWorkspace(const PhysicsModel& model);

  std::vector<PropStatus> status;  // of each prop during the step
  std::vector<int> awake_by_type;  // number of awake props
  std::vector<int> slot;           // of each awake prop in the scene in use, or kNoSlot
  std::vector<int> prop;           // in each slot of the scene in use, or kNoProp
  std::vector<PropMotion> motion;  // of awake and moving props, between scenes
  std::vector<int> moving;         // kinematic props in motion
  std::vector<KinematicBody> kinematic_bodies;  // bodies of those in the scene in use
};

struct EnvStep {
  static constexpr int kNoSlot = -1;  // of a prop that woke in this scene
  static constexpr int kNoProp = -1;  // in an empty slot

  EnvStep(const PhysicsModel& physics_model, const State& columns, int environment,
          StepWorkspace& memory, RobotBounds::Clearance& robot_clearance,
          StepClock::Worker* step_clock)
      : model(physics_model),
        state(columns),
        env(environment),
        workspace(memory),
        clearance(robot_clearance),
        clock(step_clock) {}

  const PhysicsModel& model;
  const State& state;  // holds the state before this step until SceneBinding::store
  int env;
  StepWorkspace& workspace;
  RobotBounds::Clearance& clearance;  // of the robot, as last found
  StepClock::Worker* clock;           // may be null
  JointArray contact_force{};         // on the robot's joints in the last substep, N m, N

  // --- scene in use ---

  int scene_index = 0;
  const SceneModel* scene = nullptr;
  SceneInstance* instance = nullptr;

  const mjModel& scene_model() const { return *scene->model; }
  mjData& data() const { return *instance->data; }
  // Tests for a scene with more than robot and table.
  bool scene_has_props() const { return scene_index > PhysicsModel::kRobotScene; }
  // Slot of an awake prop.
  const PropSlot& slot_of(int prop) const { return scene->slots[at(workspace.slot[at(prop)])]; }
  // Smallest scene with slots for awake props, and with the kinematic ones if they are needed.
  int smallest_scene(bool kinematic_props) const {
    return model.smallest_scene(workspace.awake_by_type, kinematic_props);
  }

  // --- props ---

  int num_awake = 0;

  int num_props() const { return state.num_props; }
  const PropModel& prop_model(int prop) const { return model.props()[at(prop)]; }
  bool is_awake(int prop) const { return workspace.status[at(prop)] == PropStatus::kAwake; }
  bool is_asleep(int prop) const { return workspace.status[at(prop)] == PropStatus::kAsleep; }
  // Kinematic props in motion count as asleep.
  const std::vector<int>& moving() const { return workspace.moving; }
  bool is_moving(int prop) const {
    return std::find(moving().begin(), moving().end(), prop) != moving().end();
  }
  // Displacement of a moving kinematic prop in this control step, m.
  const double* displacement_of(int prop) const { return state.prop_qvel_of(env, prop); }
  // Makes a free prop awake. The next selected scene has a slot for it.
  void wake(int prop);
};

}  // namespace engram
