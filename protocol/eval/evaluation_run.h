// An evaluation on rank 0: its open tasks, its results and its files.
#pragma once

#include <chrono>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "protocol/eval/results/result_files.h"
#include "protocol/eval/run/evaluate.h"

namespace engram {

class EvaluationRun {
 public:
  // Takes over the results that the folder already holds, if a folder is given.
  EvaluationRun(EvaluationSettings settings, std::optional<ResultFolder> folder);

  const EvaluationSettings& settings() const { return settings_; }
  const std::optional<ResultFolder>& folder() const { return folder_; }
  // Tasks without a result, in the registry's order.
  std::vector<const RegistryEntry*> open_tasks() const;
  // Writes the task's files and the summary.
  void add(const TaskResult& result);
  // Writes summary and report, and opens a sealed run. compute: the machine, as text.
  void finish(const std::string& compute, bool keep_sealed = false);

  // Results in the registry's order, and {summary, tasks}.
  JsonList tasks() const;
  Json document() const;
  // Steps in which physics diverged.
  std::uint64_t unstable() const { return unstable_; }

 private:
  void open();

  EvaluationSettings settings_;
  std::optional<ResultFolder> folder_;
  std::map<std::string, Json> finished_;
  std::uint64_t unstable_ = 0;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

}  // namespace engram
