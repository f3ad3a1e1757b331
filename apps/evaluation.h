// The evaluation protocol of common 12.2: fixed seeds, one episode each, success at any step.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "protocol/json.h"
#include "protocol/make.h"

namespace engram::apps {

struct Protocol {
  Policy policy = Policy::kOracle;
  int episodes = 50;
  std::uint64_t start_seed = 4242424242;  // episode i has seed start_seed + i
  int num_envs = 256;                     // episodes that run at the same time, at most
  int threads = 0;
  EnvOptions observation;  // obs_mode and image_options count
};

// What came out for one task; vectors have one element per episode. The same for every number of
// environments and threads.
struct TaskResult {
  const RegistryEntry* entry = nullptr;
  double chance = 1;  // success rate of guessing
  std::vector<bool> successes;
  std::vector<double> returns;
  std::vector<int> lengths;  // control steps
  std::vector<std::uint64_t> seeds;
  std::uint64_t unstable = 0;  // steps in which physics diverged

  double success_rate() const;
  double mean_return() const;
  double mean_length() const;
};

// progress: called with the finished fraction of this task.
TaskResult evaluate(const RegistryEntry& entry, const Protocol& protocol,
                    const std::function<void(double)>& progress);

// The documents of common 12.2, with its keys in its order, and the chance level.
Json task_document(const TaskResult& result, const Protocol& protocol);
Json summary_document(const std::vector<TaskResult>& results);

}  // namespace engram::apps
