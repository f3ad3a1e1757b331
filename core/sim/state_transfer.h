// Transfer of one environment between its columns and the working memory of a step.
#pragma once

#include "core/robot/robot_pose.h"
#include "core/sim/env_step.h"

namespace engram {

class StateTransfer {
 public:
  explicit StateTransfer(EnvStep& step)
      : step_(step), workspace_(step.workspace), state_(step.state), env_(step.env) {}

  // Tests that all numbers in the columns are finite and not huge.
  bool state_is_plausible() const;

  // Reads which props are awake or in motion. Without `sleep` every free prop that is present is
  // awake.
  void begin(bool sleep);
  // Reads what the contact law remembers; before the first substep in which something may touch.
  void load_contacts();

  // Moves kinematic props in motion to their positions after `substep` of the control step's
  // substeps.
  void move_kinematic_props(int substep, int substeps);

  // Sets the states of all bodies that collide: the robot's links, whose speeds the broad phase has
  // found, then props, which enter it.
  void pose_links(const RobotPose& robot, const BroadPhase& broad_phase, int lane);
  void pose_props(BroadPhase& broad_phase, int lane);

  // Tests that all numbers of the robot and of awake props are finite and not huge.
  bool is_plausible(const JointArray& qpos, const JointArray& qvel) const;

  // Writes robot, props and contacts into the columns.
  void store(const JointArray& qpos, const JointArray& qvel);
  // Writes the force that each prop exerts on each finger in the last substep.
  void store_finger_forces(int lane, const ContactBlock& block) const;

 private:
  bool pose_kinematic(int prop);
  bool pose_free(int prop);
  void store_contacts() const;
  void keep_resting_contacts() const;

  // Columns of what is remembered of the environment's pairs.
  std::int32_t* pair_ids(int pair) const {
    return state_.contact_ids.row(env_) + pair * StoredPair::kInts;
  }
  float* pair_values(int pair) const {
    return state_.contact_values.row(env_) + pair * StoredPair::kFloats;
  }
  void clear_pair(int pair) const;

  EnvStep& step_;
  StepWorkspace& workspace_;
  const State& state_;
  int env_;
  bool contacts_loaded_ = false;
  bool resting_posed_ = false;  // kinematic props that do not move
};

}  // namespace engram
