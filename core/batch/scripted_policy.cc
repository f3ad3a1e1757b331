#include "core/batch/scripted_policy.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "core/base/error.h"
#include "core/base/ieee_scope.h"
#include "core/task/expert.h"

namespace engram {
namespace {

std::optional<Script> script_of(Policy policy) {
  switch (policy) {
    case Policy::kOracle:
      return Script::kOracle;
    case Policy::kBlind:
      return Script::kBlind;
    case Policy::kSweep:
      return Script::kSweep;
    case Policy::kZero:
    case Policy::kRandom:
      return std::nullopt;
  }
  return std::nullopt;
}

}  // namespace

void require_mode_of(Policy policy, ControlMode mode) {
  const bool known = mode == ControlMode::kPdEeDeltaPose || mode == ControlMode::kPdJointPos ||
                     mode == ControlMode::kPdJointDeltaPos;
  if (known || !script_of(policy)) return;
  throw Error(Error::kInvalidArgument,
              std::string(name_of(policy)) + " with control mode " + name_of(mode) +
                  ", pd_ee_delta_pose, pd_joint_pos or pd_joint_delta_pos needed");
}

void ScriptedPolicy::act(std::span<float> actions) const {
  const IeeeScope scope;
  require_length("actions", actions.size(), at(batch_.num_envs()) * at(batch_.action_dim()));
  for (int i = 0; i < batch_.num_parts(); ++i) {
    const BatchData& data = BatchAccess::data(batch_.part(i));
    data.require_started("act");
    require_mode_of(policy_, *data.options.control_mode);
  }
  const auto rows_of = [&](const BatchData& data) {
    const int dim = batch_.action_dim();
    return FloatRows{actions.data() + at(data.first_env) * at(dim), dim};
  };
  BatchAccess::for_ranges(batch_, [&](int part, int /*worker*/, Range envs) {
    const BatchData& data = BatchAccess::data(batch_.part(part));
    act_range(data, envs, rows_of(data));
  });
  for (int i = 0; i < batch_.num_parts(); ++i) {
    BatchData& data = BatchAccess::data(batch_.part(i));
    if (data.batch_task != nullptr) act_batch_task(data, rows_of(data));
  }
}

void ScriptedPolicy::act_range(const BatchData& data, Range envs, FloatRows actions) const {
  const std::optional<Script> script = script_of(policy_);
  if (script) run_script(data, envs, *script, actions);
  for (int env = envs.begin; env < envs.end; ++env) {
    float* row = actions.row(env);
    if (policy_ == Policy::kZero) std::fill_n(row, actions.stride, 0.0F);
    if (policy_ == Policy::kRandom) act_randomly(data, env, row);
    if (script) adapt(data, env, row);
  }
}

// From pd_ee_delta_pose with rotation sign -1, for which scripts act, to the batch's mode.
void ScriptedPolicy::adapt(const BatchData& data, int env, float* action) const {
  if (data.options.rotation_sign == 1) {
    for (int i = 3; i < 6; ++i) action[i] = -action[i];
  }
  const Controller& controller = *data.controller;
  if (controller.follows_pose_actions()) {
    controller.joint_action(data.state, env, action, action);
  }
}

// True for an environment that waits behind its episode for a reset.
bool ScriptedPolicy::stands_still(const BatchData& data, int env) const {
  const BatchOptions& options = data.options;
  return data.state.finished[env] != 0 && options.auto_reset == AutoReset::kOff &&
         options.after_end != AfterEnd::kContinue;
}

// Environments that stand still are left out: their actions are zero.
void ScriptedPolicy::run_script(const BatchData& data, Range envs, Script script,
                                FloatRows actions) const {
  const Expert& expert = data.task->expert();
  for (int env = envs.begin; env < envs.end;) {
    const int begin = env;
    while (env < envs.end && !stands_still(data, env)) ++env;
    if (begin < env) expert.act({begin, env}, script, actions);
    for (; env < envs.end && stands_still(data, env); ++env) {
      std::fill_n(actions.row(env), actions.stride, 0.0F);
    }
  }
}

void ScriptedPolicy::act_batch_task(BatchData& data, FloatRows actions) const {
  const std::optional<Script> script = script_of(policy_);
  if (!script) {
    act_range(data, {0, data.num_envs()}, actions);
    return;
  }
  std::vector<int>& acting = data.list;
  acting.clear();
  for (int env = 0; env < data.num_envs(); ++env) {
    std::fill_n(actions.row(env), actions.stride, 0.0F);
    if (!stands_still(data, env)) acting.push_back(env);
  }
  if (acting.empty()) return;
  data.batch_task->act(acting, *script, actions);
  for (const int env : acting) adapt(data, env, actions.row(env));
}

// Uniform over the action space; a function of seed, episode and step alone. Unbounded components
// stay near the robot's present position.
void ScriptedPolicy::act_randomly(const BatchData& data, int env, float* action) const {
  constexpr double kUnboundedSpread = 0.05;
  const State& state = data.state;
  const auto step = static_cast<std::uint32_t>(state.elapsed[env]);
  RandomStream stream(data.bindings.policy_key(env), state.episode[env],
                      kPurposeRandomPolicy + step);
  const ActionSpace& space = data.controller->action_space();
  data.controller->hold_action(state, env, action);
  for (std::size_t i = 0; i < space.low.size(); ++i) {
    if (std::isfinite(space.low[i])) {
      action[i] = static_cast<float>(
          stream.uniform(static_cast<double>(space.low[i]), static_cast<double>(space.high[i])));
    } else {
      action[i] += static_cast<float>(stream.uniform(-kUnboundedSpread, kUnboundedSpread));
    }
  }
}

}  // namespace engram
