// The reward of training: differences of a potential, and the rest of the horizon at success.
#pragma once

#include <cstdint>
#include <vector>

#include "core/batch/batch.h"
#include "protocol/training/numbers.h"

namespace engram::training {

// What a step has led to, the last values of the episode where it has ended.
struct StepResult {
  float reward = 0;                     // the batch's own
  const float* reward_terms = nullptr;  // of the task's reward; NaN where there is none yet
  std::int32_t elapsed = 0;
  bool failed = false;  // the episode has ended without success
  bool success_once = false;
  bool idle = false;  // no step was taken
};

// Rewards of a batch's environments. Equations: docs/learning.md.
class ShapedReward {
 public:
  // Options are in their ranges.
  ShapedReward(const Batch& batch, const Options& options);

  // Forgets an environment's episode.
  void begin(int env);
  float step(int env, const StepResult& result);

 private:
  static constexpr int kNone = -1;
  // A term of one task's reward, by columns of it.
  struct Term {
    int column = 0;
    double weight = 0;
    bool is_distance = false;
    int until = kNone;
    int since = kNone;
  };
  // One task of the batch.
  struct Part {
    std::vector<Term> terms;
    std::int32_t horizon = 0;
  };
  struct Episode {
    double potential = 0;
    bool succeeded = false;
  };

  static std::vector<Term> terms_of(const TaskInfo& info, double still, const char* place);
  double potential_of(const Part& part, const StepResult& result) const;
  double held_value(const Part& part, std::int32_t elapsed) const;

  Options options_;
  std::vector<Part> parts_;
  std::vector<int> part_of_;  // (num_envs)
  std::vector<Episode> episodes_;
};

}  // namespace engram::training
