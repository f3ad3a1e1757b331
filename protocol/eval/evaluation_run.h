// An evaluation on rank 0: its open tasks, its results and its files.
#pragma once

#include <chrono>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "protocol/eval/results/policy_identity.h"
#include "protocol/eval/results/result_files.h"
#include "protocol/eval/run/evaluate.h"
#include "protocol/parallel/run_header.h"

namespace engram {

// Kind of a run, in journals.
inline constexpr const char* kEvaluationKind = "eval";

class EvaluationRun {
 public:
  // Takes over the results that the folder already holds, if a folder is given. Throws Error as
  // Journal does.
  EvaluationRun(EvaluationSettings settings, std::optional<ResultFolder> folder,
                EpisodePart part = {});

  const EvaluationSettings& settings() const { return settings_; }
  const std::optional<ResultFolder>& folder() const { return folder_; }
  // Tasks without a result, in the registry's order.
  std::vector<const RegistryEntry*> open_tasks() const;
  // Where finished episodes go.
  EpisodeStore store() const { return {journal_.get(), part_.shard.value_or(Shard())}; }
  const std::optional<Shard>& shard() const { return part_.shard; }
  // Where what the policy tells of itself goes.
  const std::shared_ptr<PolicyIdentity>& identity() const { return identity_; }
  // Episodes in the journal.
  std::size_t journaled() const { return journal_ ? journal_->size() : 0; }
  // Writes the task's files and the summary. Of a shard, the episodes are all there is.
  void add(const TaskResult& result);
  // Writes summary and report, and opens a sealed run. compute: the machine, as text.
  void finish(const std::string& compute, bool keep_sealed = false);

  // Results in the registry's order, and {summary, tasks}.
  JsonList tasks() const;
  Json document() const;
  // {shard, out, episodes} of a shard.
  JsonTable shard_document() const;
  // Steps in which physics diverged.
  std::uint64_t unstable() const { return unstable_; }

 private:
  void open();

  EvaluationSettings settings_;
  std::optional<ResultFolder> folder_;
  EpisodePart part_;
  std::shared_ptr<PolicyIdentity> identity_;
  std::unique_ptr<Journal> journal_;  // of runs with a folder
  std::map<std::string, Json> finished_;
  std::uint64_t unstable_ = 0;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

}  // namespace engram
