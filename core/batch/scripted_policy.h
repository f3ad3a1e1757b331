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

 private:
  // actions: of all environments of the data.
  void act_range(const BatchData& data, Range envs, FloatRows actions) const;
  void act_batch_task(BatchData& data, FloatRows actions) const;
  bool stands_still(const BatchData& data, int env) const;
  void run_script(const BatchData& data, Range envs, Script script, FloatRows actions) const;
  void adapt(const BatchData& data, int env, float* action) const;
  void act_randomly(const BatchData& data, int env, float* action) const;

  Batch& batch_;
  Policy policy_;
};

}  // namespace engram
