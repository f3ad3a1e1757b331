// Policies that a batch brings along.
#pragma once

#include <span>

#include "core/batch/batch.h"
#include "core/task/expert.h"

namespace engram {

// Throws Error if the policy is a script, and scripts have no actions for the mode: they have some
// for pd_ee_delta_pose, pd_joint_pos and pd_joint_delta_pos.
void require_mode_of(Policy policy, ControlMode mode);

// Zero, random, or one of the task's scripts: oracle, blind, sweep.
class ScriptedPolicy {
 public:
  ScriptedPolicy(Batch& batch, Policy policy) : batch_(batch), policy_(policy) {}

  // Writes actions for the next step, (num_envs, action_dim). Oracle, blind and sweep need
  // pd_ee_delta_pose, pd_joint_pos or pd_joint_delta_pos. Throws Error if they cannot act, the
  // length is wrong or nothing was reset.
  void act(std::span<float> actions) const;
  // Actions of a range of environments of a task without BatchTask, after check(), which throws the
  // errors but for lengths. actions: of all environments. Ranges may be on several threads.
  void act_range(Range envs, float* actions) const;
  void check() const;

 private:
  bool stands_still(int env) const;
  void run_script(Range envs, Script script, FloatRows actions) const;
  void run_script_by_rules(Script script, FloatRows actions) const;
  void adapt(int env, float* action) const;
  void act_randomly(int env, float* action) const;

  Batch& batch_;
  Policy policy_;
};

}  // namespace engram
