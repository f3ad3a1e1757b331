// State of every environment of a batch, as columns.
#pragma once

#include <cstdint>

#include "core/base/column.h"
#include "core/robot/arm.h"

namespace engram {

enum class PropStatus : std::uint8_t {
  kHidden = 0,  // not in the scene: invisible, no collisions, no motion
  kAsleep = 1,  // present and at rest: not simulated until something comes near
  kAwake = 2,   // present and simulated; kinematic props: in motion during the next control step
};

// Column views; the arrays live in the ColumnStore that they were added to.
struct State {
  State() = default;
  // `contact_pairs`: most pairs of shapes that the contact law remembers of an environment.
  State(ColumnStore& store, int num_props, int contact_pairs = 0);

  int num_props = 0;
  int num_contact_pairs = 0;

  // Episode.
  Column<std::uint64_t> seed;     // of the environment, set by reset
  Column<std::uint64_t> episode;  // counts automatic resets since then
  Column<std::int32_t> elapsed;   // control steps since the episode began
  Column<std::uint8_t> finished;  // terminated or truncated; waits for a reset

  // Robot: seven arm joints, left finger, right finger.
  Column<double> qpos;         // (9) rad, m
  Column<double> qvel;         // (9) rad/s, m/s
  Column<double> tcp_pos;      // (3) m, world
  Column<double> tcp_quat;     // (4) w, x, y, z
  Column<double> target_qpos;  // (7) controller state of the joint target mode
  Column<double> target_pose;  // (7) controller state of the pose target modes, root frame

  // Props, in task order; a row holds all props of one environment.
  Column<double> prop_pos;   // (num_props * 3) m, as observations report it
  Column<double> prop_quat;  // (num_props * 4)
  // (num_props * 6) linear (world), angular (body). For a kinematic prop in motion: its
  // displacement in this control step, m.
  Column<double> prop_qvel;
  Column<std::uint8_t> prop_status;      // (num_props) PropStatus
  Column<std::uint8_t> prop_slow_steps;  // (num_props) consecutive control steps at rest
  // Colour in images instead of the document's, if its alpha is positive; emitted light.
  Column<float> prop_rgba;      // (num_props * 4) 0..1
  Column<float> prop_emission;  // (num_props)
  // Bit mask of props that are present but occluded, because another one stands over them.
  Column<std::uint64_t> covered;
  // (num_props * 2 * 3) force of a prop on each finger in the last substep, N, world frame; left
  // finger first.
  Column<double> finger_force;
  // Memory of the contact law (StoredPair), pairs in the order of solving; the first empty
  // one ends an environment's list.
  Column<std::int32_t> contact_ids;  // (num_contact_pairs * StoredPair::kInts)
  Column<float> contact_values;      // (num_contact_pairs * StoredPair::kFloats)

  double* prop_pos_of(int env, int prop) const { return prop_pos.row(env) + 3 * prop; }
  double* prop_quat_of(int env, int prop) const { return prop_quat.row(env) + 4 * prop; }
  double* prop_qvel_of(int env, int prop) const { return prop_qvel.row(env) + 6 * prop; }
  PropStatus status_of(int env, int prop) const {
    return static_cast<PropStatus>(prop_status.row(env)[prop]);
  }

  // Forgets contact points and friction anchors of a prop, as the original does whenever a task
  // sets a pose.
  void forget_contacts(int env, int prop) const;
  // Places a prop without velocity, asleep. Pass kAwake for a pose in which physics has to act at
  // once: in the air, or in contact with something that moves.
  void place_prop(int env, int prop, const double* pos, const double* quat,
                  PropStatus status = PropStatus::kAsleep) const;
  // Moves a kinematic prop to a position, at constant velocity over the next control step. It wakes
  // props that it comes near. Call it in Task::before_physics.
  void move_kinematic(int env, int prop, const double* pos) const;
  // Removes a prop from the scene; `pos` is the position that observations report meanwhile.
  void hide_prop(int env, int prop, const double* pos) const;
};

// Tests the largest absolute arm joint velocity against a threshold, rad/s.
bool robot_is_static(const State& state, int env, double threshold = 0.2);

// Tests linear and angular speed against thresholds.
bool prop_is_static(const State& state, int env, int prop, double linear_threshold = 1e-2,
                    double angular_threshold = 1e-1);

// Tests whether both fingers measure at least `min_force` newtons within `max_angle` degrees of
// their opening directions.
bool is_grasping(const State& state, int env, int prop, double min_force = 0.5,
                 double max_angle = 85.0);

}  // namespace engram
