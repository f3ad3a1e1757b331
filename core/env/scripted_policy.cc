#include "core/env/scripted_policy.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/base/error.h"
#include "core/env/expert.h"

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
  require_mode_of(policy_, batch_.options().control_mode);
}

void ScriptedPolicy::act(std::span<float> actions) const {
  require_length(
      "actions", actions.size(),
      static_cast<std::size_t>(batch_.num_envs()) * static_cast<std::size_t>(batch_.action_dim()));
  check();
  batch_.pool_.run(batch_.num_envs(), batch_.options().chunk,
                   [&](int /*worker*/, int begin, int end) {
                     act_range({begin, end}, actions.data());
                   });
}

void ScriptedPolicy::act_range(Range envs, float* actions) const {
  const int dim = batch_.action_dim();
  const std::optional<Script> script = script_of(policy_);
  const FloatRows all{actions, dim};
  const Controller& controller = *batch_.controller_;
  if (script) run_script(envs, *script, all);
  for (int env = envs.begin; env < envs.end; ++env) {
    float* row = all.row(env);
    if (policy_ == Policy::kZero) std::fill_n(row, dim, 0.0F);
    if (policy_ == Policy::kRandom) act_randomly(env, row);
    // Scripts act for rotation sign -1.
    if (script && batch_.options().rotation_sign == 1) {
      for (int i = 3; i < 6; ++i) row[i] = -row[i];
    }
    if (script && controller.follows_pose_actions()) {
      controller.joint_action(batch_.state(), env, row, row);
    }
  }
}

// Environments that stand still after their episode are left out: their actions are zero.
void ScriptedPolicy::run_script(Range envs, Script script, FloatRows actions) const {
  const Expert& expert = batch_.task_->expert();
  const BatchOptions& options = batch_.options();
  if (options.auto_reset != AutoReset::kOff || options.after_end == AfterEnd::kContinue) {
    expert.act(envs, script, actions);
    return;
  }
  const auto& finished = batch_.state().finished;
  for (int env = envs.begin; env < envs.end;) {
    const int begin = env;
    while (env < envs.end && finished[env] == 0) ++env;
    if (begin < env) expert.act({begin, env}, script, actions);
    for (; env < envs.end && finished[env] != 0; ++env) {
      std::fill_n(actions.row(env), batch_.action_dim(), 0.0F);
    }
  }
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
