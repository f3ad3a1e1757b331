// Documents of evaluations that nobody has run.
#pragma once

#include <string>
#include <vector>

#include "protocol/eval/results/result_files.h"
#include "protocol/io/json_checksum.h"

namespace engram::test {

// The document of a task with these successes, one episode after the other.
inline Json task_of(const std::string& id, const std::vector<bool>& successes,
                    EvaluationSettings settings = {}) {
  TaskResult result;
  result.entry = &require_entry(id);
  result.successes = successes;
  result.returns.assign(successes.size(), 0.5);
  result.lengths.assign(successes.size(), 10);
  for (std::size_t i = 0; i < successes.size(); ++i) {
    result.digests.push_back({i, successes[i] ? 1U : 2U, i, 7});
  }
  settings.episodes = static_cast<int>(successes.size()) / settings.repeat;
  if (settings.policy.empty()) settings.policy = "mine";
  return task_document(result, settings);
}

// The document with another value under a key, and the checksum of that.
inline Json with_value(const Json& document, std::string_view key, Json value) {
  JsonTable all = table(document);
  all.pop_back();
  for (auto& [name, old] : all) {
    if (name == key) old = value;
  }
  add_checksum(all);
  return all;
}

}  // namespace engram::test
