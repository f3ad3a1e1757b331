// Running batches, for all suites.
#pragma once

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "bench/interleave.h"
#include "bench/measurement.h"
#include "core/batch/scripted_policy.h"
#include "core/threads/processors.h"
#include "protocol/make/make.h"

namespace engram::bench {

inline constexpr const char* kMainId = "RememberColor9-VLA-v0";

inline std::vector<std::string> ids_or(const SuiteOptions& options,
                                       const std::vector<std::string>& usual) {
  return options.ids.empty() ? usual : options.ids;
}

inline int envs_or(const SuiteOptions& options, int usual) {
  return options.num_envs > 0 ? options.num_envs : usual;
}

// 0: one per core.
inline int threads_or_all(int threads) {
  const int cores = available_processors();
  return threads > 0 ? threads : cores;
}

inline Measurement make_measurement(std::string name, std::string unit, std::string baseline,
                                    const Comparison& result, int rounds) {
  return {std::move(name), result.value, std::move(unit), std::move(baseline),
          result.baseline, result.ratio, rounds};
}

// A batch with actions of a policy at hand.
struct Rollout {
  std::unique_ptr<Batch> batch;
  std::vector<float> actions;
  Policy policy;

  Rollout(const std::string& id, const MakeOptions& options, Policy chosen)
      : batch(make(id, options)), policy(chosen) {
    actions.resize(static_cast<std::size_t>(batch->num_envs() * batch->action_dim()));
    batch->reset();
  }

  void choose() { ScriptedPolicy(*batch, policy).act(actions); }
  double step_seconds() {
    return seconds([this] { batch->step(actions); });
  }
  // Environment steps per second over `steps` control steps; choosing actions is not timed.
  double rate(int steps) {
    double spent = 0;
    for (int i = 0; i < steps; ++i) {
      choose();
      spent += step_seconds();
    }
    return steps * batch->num_envs() / spent;
  }
};

// A rollout of several tasks in one batch.
struct GroupRollout {
  std::unique_ptr<Batch> group;
  std::vector<float> actions;
  Policy policy;

  // each: environments of each task.
  GroupRollout(const std::vector<std::string>& ids, int each, const MakeOptions& options,
               Policy chosen)
      : policy(chosen) {
    std::vector<TaskShare> shares;
    for (const std::string& id : ids) shares.push_back({id, each});
    group = make_group(shares, options);
    actions.resize(static_cast<std::size_t>(group->num_envs() * group->action_dim()));
    group->reset();
  }

  double rate(int steps) {
    double spent = 0;
    for (int i = 0; i < steps; ++i) {
      ScriptedPolicy(*group, policy).act(actions);
      spent += seconds([this] { group->step(actions); });
    }
    return steps * group->num_envs() / spent;
  }
};

inline MakeOptions rollout_options(int num_envs, int threads, Physics physics = Physics::kEngram) {
  MakeOptions options;
  options.physics = physics;
  options.num_envs = num_envs;
  options.threads = threads;
  options.seed = 1;
  // Same-step resets, so that every step is a step of every environment.
  options.auto_reset = AutoReset::kSameStep;
  return options;
}

}  // namespace engram::bench
