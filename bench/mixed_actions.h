// Actions of batches in which some environments act at random and others follow the oracle.
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

#include "core/batch/batch.h"
#include "core/batch/scripted_policy.h"

namespace engram::bench {

class MixedActions {
 public:
  explicit MixedActions(const Batch& batch)
      : actions_(static_cast<std::size_t>(batch.num_envs()) *
                 static_cast<std::size_t>(batch.action_dim())),
        scripted_(actions_.size()) {}

  // Actions for the batch's next step: the oracle's where `solved(i)` says so of environment i,
  // random ones elsewhere. Valid until the next call.
  template <class Solved>
  std::span<const float> choose(Batch& batch, Solved&& solved) {
    ScriptedPolicy(batch, Policy::kRandom).act(actions_);
    ScriptedPolicy(batch, Policy::kOracle).act(scripted_);
    const std::ptrdiff_t dim = batch.action_dim();
    for (int i = 0; i < batch.num_envs(); ++i) {
      if (!solved(i)) continue;
      std::copy_n(scripted_.begin() + i * dim, dim, actions_.begin() + i * dim);
    }
    return actions_;
  }

 private:
  std::vector<float> actions_;
  std::vector<float> scripted_;
};

}  // namespace engram::bench
