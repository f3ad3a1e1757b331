// The benchmark's evaluation protocol (docs/evaluation.md): fixed seeds, one episode each, success
// in any step.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "protocol/eval/policies/external_policy.h"
#include "protocol/eval/run/run_options.h"
#include "protocol/io/journal.h"
#include "protocol/make/make.h"
#include "protocol/parallel/scheduler.h"
#include "protocol/parallel/shares.h"

namespace engram {

// Makes the external policy of one worker thread; called by that thread, on every rank.
using PolicyFactory = std::function<std::unique_ptr<ExternalPolicy>(const WorkContext&)>;

struct Protocol : RunOptions {
  Policy policy = Policy::kOracle;
  PolicyFactory external;          // takes the place of `policy` if it is set
  int num_envs = kEvaluationEnvs;  // at most, of a thread
  int threads = 0;
  std::string number_key;   // of the opaque numbers that requests have without tell_episodes
  bool samples = false;     // images of each task's first episode
  MakeOptions environment;  // without num_envs, threads and auto_reset
};

// The first answer of the robot in an episode (docs/memory.md).
struct Answer {
  std::uint8_t given = 0;
  std::int32_t first = 0;
  std::uint8_t correct = 0;
};

// How far an episode has come: the most subtasks that were done at a time, of its plan's. All of
// them after a success.
struct Completion {
  std::int32_t done = 0;
  std::int32_t subtasks = 0;

  double share() const { return static_cast<double>(done) / subtasks; }
};

// The result of one task; vectors have one element per episode, round after round. Fields above the
// line do not depend on the numbers of environments, threads and ranks.
struct TaskResult {
  const RegistryEntry* entry = nullptr;
  double chance = 1;         // success rate of guessing
  double answer_chance = 1;  // share of right first answers of guessing
  std::vector<bool> successes;
  std::vector<double> returns;
  std::vector<int> lengths;             // control steps
  std::vector<Answer> answers;          // empty where the task asks for none
  std::vector<Completion> completions;  // empty where the task has no plan
  std::vector<std::uint64_t> seeds;
  std::vector<EpisodeDigests> digests;
  int chunk_size = 1;
  // ---
  std::uint64_t unstable = 0;  // steps in which physics diverged
  double thread_seconds = 0;   // wall time of all threads that worked on it
  // A PNG of the policy's images in the first episode, from its beginning to its end.
  Bytes sample;

  double success_rate() const;
  double answer_rate() const;      // share of episodes whose first answer is right
  double completion_rate() const;  // mean share of subtasks that were done
  double mean_return() const;
  double mean_length() const;
  std::int64_t env_steps() const;
};

struct EvaluationStatus {
  struct Running {
    const RegistryEntry* entry;
    int episodes;  // finished
  };
  std::uint64_t env_steps = 0;
  int episodes = 0;  // finished, of all
  int wanted = 0;    // of all
  int tasks = 0;
  std::vector<Running> running;
};

// Callbacks on rank 0. An exception from one of them ends the run.
struct EvaluationListener {
  std::function<void(TaskResult)> finished;           // tasks, in any order
  std::function<void(const EvaluationStatus&)> tick;  // several times a second
};

// Which of the episodes are played, and where each goes as soon as it is finished.
struct EpisodeStore {
  Journal* journal = nullptr;  // its episodes are not played again; null: none
  Shard shard = {};
};

// The loads of tasks in an evaluation, for shares.
std::vector<TaskLoad> loads_of(const std::vector<const RegistryEntry*>& tasks,
                               const RunOptions& options);

// Evaluates the tasks on all threads of all ranks, those with the longest episodes first. Every
// rank calls it with the same protocol; only rank 0's tasks, listener and store are used. A shard
// finishes the tasks alone of which it has all episodes.
void evaluate(Ranks& ranks, const std::vector<const RegistryEntry*>& tasks,
              const Protocol& protocol, const EvaluationListener& listener,
              const EpisodeStore& store = {});

}  // namespace engram
