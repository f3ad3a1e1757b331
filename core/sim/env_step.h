// Context of one environment's control step. StateTransfer, SleepManager and Simulator work on it
// side by side; it holds what they share: the environment's columns, and the state of its bodies
// while the step is under way.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "core/base/index.h"
#include "core/base/step_clock.h"
#include "core/contact/contact_step.h"
#include "core/scene/physics_model.h"
#include "core/sim/state.h"

namespace engram {

// Working memory of one environment's step. Lanes reuse it, so that steps do not allocate.
struct StepWorkspace {
  explicit StepWorkspace(const PhysicsModel& model);

  std::vector<PropStatus> status;     // of each prop during the step
  std::vector<FreeBodyState> motion;  // of awake free props
  std::vector<FreeBodyState> begin;   // the same when the control step began
  std::vector<Vec3> moving_pos;       // of kinematic props in motion
  std::vector<int> awake;             // free props that are simulated, ascending
  std::vector<int> moving;            // kinematic props in motion
  double moves_per_second = 0;        // control steps, 1/s
  BodyStates bodies;                  // of the CollisionScene
  std::vector<std::uint8_t> is_link;  // bodies whose frames are those of links
  std::vector<Frame> reach_frames;    // of the robot's shapes that can touch props
  std::vector<double> reach_gaps;     // below which they wake props, m
  ContactMemory memory;
  ContactStep contacts;
};

struct EnvStep {
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
  const State& state;  // holds the state before this step until StateTransfer::store
  int env;
  StepWorkspace& workspace;
  RobotBounds::Clearance& clearance;  // of the robot, as last found
  StepClock::Worker* clock;           // may be null

  int num_props() const { return state.num_props; }
  const PropModel& prop_model(int prop) const { return model.props()[at(prop)]; }
  bool is_awake(int prop) const { return workspace.status[at(prop)] == PropStatus::kAwake; }
  bool is_asleep(int prop) const { return workspace.status[at(prop)] == PropStatus::kAsleep; }
  const std::vector<int>& awake() const { return workspace.awake; }
  // Kinematic props in motion count as asleep.
  const std::vector<int>& moving() const { return workspace.moving; }
  bool is_moving(int prop) const {
    return std::find(moving().begin(), moving().end(), prop) != moving().end();
  }
  // Displacement of a moving kinematic prop in this control step, m.
  const double* displacement_of(int prop) const { return state.prop_qvel_of(env, prop); }
  // Makes a free prop awake, with the motion that the columns have.
  void wake(int prop);
  // Upper bound of the speed of any point of an awake prop, m/s.
  double prop_speed(int prop) const;
};

}  // namespace engram
