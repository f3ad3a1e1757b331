// Options of an evaluation on which its results depend, beside tasks, policy and environments.
#pragma once

#include <cstdint>

namespace engram {

// begin generated: constants (tools/surface, from api/surface.toml)
inline constexpr int kBenchmarkEpisodes = 50;
inline constexpr int kEvaluationEnvs = 8;
inline constexpr std::uint64_t kBenchmarkSeed = 4242424242;
inline constexpr int kMaxRepeat = 1000;
inline constexpr int kMaxLatency = 1'000'000;
inline constexpr int kMaxChoicesStride = 1'000'000;
// end generated
inline constexpr double kControlStepMilliseconds = 50;  // 20 control steps a second

struct RunOptions {
  // begin generated: fields
  // Episodes of each task. 1 or more.
  int episodes = kBenchmarkEpisodes;
  // Episode i has seed + i.
  std::uint64_t start_seed = kBenchmarkSeed;
  // Requests have numbers and seeds of episodes.
  bool tell_episodes = false;
  // Rounds of the same episodes; round i has policy_seed + i. 1 to 1000.
  int repeat = 1;
  // Seed of the policy's own random numbers, part of every request.
  std::uint64_t policy_seed = 0;
  // Control steps from a request to its answer, such as "3", or milliseconds, "120ms": the world
  // goes on with the last action meanwhile.
  int latency = 0;
  // The policy names answers, and a scripted hand acts.
  bool choices = false;
  // Interval of the frames of questions, for engram_evaluate_choices. 1 to 1,000,000 control steps.
  int choices_stride = 1;
  // end generated

  // Episodes of a task, all rounds together.
  int all_episodes() const { return episodes * repeat; }
};

}  // namespace engram
