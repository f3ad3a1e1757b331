// The policies that a batch brings along.
#include <algorithm>
#include <cmath>
#include <optional>

#include "core/base/error.h"
#include "core/base/length.h"
#include "core/env/batch.h"
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

void Batch::act(Policy policy, std::span<float> actions) {
  const auto dim = static_cast<std::size_t>(action_dim());
  require_length("actions", actions.size(), static_cast<std::size_t>(num_envs()) * dim);
  if (!started_) throw Error(Error::kBadState, "act before the first reset; reset first");
  const std::optional<Script> script = script_of(policy);
  const bool scripted = script.has_value();
  if (scripted && options_.control_mode != ControlMode::kPdEeDeltaPose) {
    throw Error(Error::kInvalidArgument, std::string(name_of(policy)) + " with control mode " +
                                             name_of(options_.control_mode) +
                                             ", pd_ee_delta_pose needed");
  }
  const FloatRows all{actions.data(), action_dim()};
  const Expert& expert = task_->expert();
  // Environments that stand still after their episode are left out: their actions are zero.
  const auto act_moving = [&](Range envs) {
    if (options_.auto_reset != AutoReset::kOff || options_.after_end == AfterEnd::kContinue) {
      expert.act(envs, *script, all);
      return;
    }
    for (int env = envs.begin; env < envs.end;) {
      const int begin = env;
      while (env < envs.end && state_.finished[env] == 0) ++env;
      if (begin < env) expert.act({begin, env}, *script, all);
      for (; env < envs.end && state_.finished[env] != 0; ++env) {
        std::fill_n(all.row(env), dim, 0.0F);
      }
    }
  };
  pool_.run(num_envs(), options_.chunk, [&](int /*worker*/, int begin, int end) {
    if (scripted) act_moving({begin, end});
    for (int env = begin; env < end; ++env) {
      float* row = all.row(env);
      if (policy == Policy::kZero) std::fill_n(row, dim, 0.0F);
      if (policy == Policy::kRandom) random_action(env, row);
      // Scripts act for rotation sign -1.
      if (scripted && options_.rotation_sign == 1) {
        for (int i = 3; i < 6; ++i) row[i] = -row[i];
      }
    }
  });
}

// Uniform over the action space; a function of seed, episode and step alone. Unbounded components
// stay near the robot's present position.
void Batch::random_action(int env, float* action) const {
  constexpr double kUnboundedSpread = 0.05;
  const auto step = static_cast<std::uint32_t>(state_.elapsed[env]);
  RandomStream stream(bindings_.stream_key(env), state_.episode[env], kPurposeRandomPolicy + step);
  const ActionSpace& space = action_space();
  controller_->hold_action(state_, env, action);
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
