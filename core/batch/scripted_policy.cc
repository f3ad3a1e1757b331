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

void ScriptedPolicy::check() const {
  batch_.require_started("act");
  require_mode_of(policy_, batch_.control_mode());
}

void ScriptedPolicy::act(std::span<float> actions) const {
  require_length(
      "actions", actions.size(),
      static_cast<std::size_t>(batch_.num_envs()) * static_cast<std::size_t>(batch_.action_dim()));
  check();
  const std::optional<Script> script = script_of(policy_);
  if (script && batch_.rules_ != nullptr) {
    run_script_by_rules(*script, {actions.data(), batch_.action_dim()});
    return;
  }
  batch_.pool_.run(batch_.num_envs(), batch_.options().chunk,
                   [&](int /*worker*/, int begin, int end) {
                     act_range({begin, end}, actions.data());
                   });
}

void ScriptedPolicy::act_range(Range envs, float* actions) const {
  const int dim = batch_.action_dim();
  const std::optional<Script> script = script_of(policy_);
  const FloatRows all{actions, dim};
  if (script) run_script(envs, *script, all);
  for (int env = envs.begin; env < envs.end; ++env) {
    float* row = all.row(env);
    if (policy_ == Policy::kZero) std::fill_n(row, dim, 0.0F);
    if (policy_ == Policy::kRandom) act_randomly(env, row);
    if (script) adapt(env, row);
  }
}

// From pd_ee_delta_pose with rotation sign -1, for which scripts act, to the batch's mode.
void ScriptedPolicy::adapt(int env, float* action) const {
  if (batch_.options().rotation_sign == 1) {
    for (int i = 3; i < 6; ++i) action[i] = -action[i];
  }
  const Controller& controller = *batch_.controller_;
  if (controller.follows_pose_actions()) {
    controller.joint_action(batch_.state(), env, action, action);
  }
}

// True for an environment that waits behind its episode for a reset.
bool ScriptedPolicy::stands_still(int env) const {
  const BatchOptions& options = batch_.options();
  return batch_.state().finished[env] != 0 && options.auto_reset == AutoReset::kOff &&
         options.after_end != AfterEnd::kContinue;
}

// Environments that stand still are left out: their actions are zero.
void ScriptedPolicy::run_script(Range envs, Script script, FloatRows actions) const {
  const Expert& expert = batch_.task_->expert();
  for (int env = envs.begin; env < envs.end;) {
    const int begin = env;
    while (env < envs.end && !stands_still(env)) ++env;
    if (begin < env) expert.act({begin, env}, script, actions);
    for (; env < envs.end && stands_still(env); ++env) {
      std::fill_n(actions.row(env), batch_.action_dim(), 0.0F);
    }
  }
}

void ScriptedPolicy::run_script_by_rules(Script script, FloatRows actions) const {
  const IeeeScope scope;
  std::vector<int>& acting = batch_.work_.stepping;
  acting.clear();
  for (int env = 0; env < batch_.num_envs(); ++env) {
    std::fill_n(actions.row(env), batch_.action_dim(), 0.0F);
    if (!stands_still(env)) acting.push_back(env);
  }
  if (acting.empty()) return;
  batch_.rules_->act(acting, script, actions);
  for (const int env : acting) adapt(env, actions.row(env));
}

// Uniform over the action space; a function of seed, episode and step alone. Unbounded components
// stay near the robot's present position.
void ScriptedPolicy::act_randomly(int env, float* action) const {
  constexpr double kUnboundedSpread = 0.05;
  const State& state = batch_.state();
  const auto step = static_cast<std::uint32_t>(state.elapsed[env]);
  RandomStream stream(batch_.bindings_.policy_key(env), state.episode[env],
                      kPurposeRandomPolicy + step);
  const ActionSpace& space = batch_.action_space();
  batch_.controller_->hold_action(state, env, action);
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
