// Long runs over many tasks that watch for growth, drift and instability.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "bench/process_usage.h"
#include "core/batch/options.h"

namespace engram::bench {

struct SoakOptions {
  std::vector<std::string> ids;         // empty: all tasks
  std::int64_t env_steps = 10'000'000;  // in total, rounded up; 0: none
  int cycles = 10'000;                  // batches that are made and closed; 0: none
  int threads = 0;                      // of a batch; 0: one per core
  std::uint64_t seed = 1;               // environment i has seed + i
  Physics physics = Physics::kEngram;
  // The most that the median drift of the tasks' last visits may be. Two identical runs on a quiet
  // machine differ by a few percent.
  double max_drift = 1.10;
  std::function<void(double fraction)> progress;  // after every visit and cycle; may be empty
  std::function<bool()> stop;  // asked as often; true: report what was done so far; may be empty
};

// The memory and other resources of the process at one moment.
struct SoakSample {
  std::int64_t done = 0;  // environment steps or cycles
  ProcessUsage usage;
};

// Environments run random and oracle episodes in turn.
inline constexpr std::array kSoakPolicies = {Policy::kRandom, Policy::kOracle};

// A visit: some steps of one task. The next visit continues from its last state.
struct SoakVisit {
  double env_steps_per_second = 0;
  // Time of a fixed piece of work, relative to the first visit. Time is measured in units of a
  // reference that runs beside it.
  double drift = 1;
  std::uint64_t digest = 0;  // of the results of that work
  double grown_bytes = 0;    // of the heap, while stepping
  // Episodes that ended, and how many of them had success, by kSoakPolicies.
  std::array<int, 2> episodes{};
  std::array<int, 2> successes{};
};

struct SoakTask {
  std::string id;
  std::vector<SoakVisit> visits;
};

// An episode whose physics diverged. To reproduce it: a batch of one with that seed, reset
// `episode` times more than once, then steps of that policy.
struct UnstableEpisode {
  std::string id;
  std::uint64_t seed = 0;
  std::uint64_t episode = 0;
  Policy policy = Policy::kRandom;
  int elapsed = 0;  // the step that diverged
};

// A bound that must hold at the end.
struct SoakBound {
  std::string name;
  double value = 0;
  double allowed = 0;  // at most
  std::string unit;
  bool kept() const { return value <= allowed; }
};

struct SoakReport {
  std::int64_t env_steps = 0;
  int cycles = 0;
  int threads = 0;
  bool stopped = false;  // before all was done; bounds are of what was
  double step_seconds = 0;
  double cycle_seconds = 0;
  std::vector<SoakSample> step_samples;   // while no batch is alive
  std::vector<SoakSample> cycle_samples;  // likewise
  std::vector<SoakTask> tasks;
  std::vector<UnstableEpisode> unstable;
  std::vector<SoakBound> bounds;

  bool passed() const;
};

// Throws Error for an unknown id or negative numbers.
SoakReport soak(const SoakOptions& options);

}  // namespace engram::bench
