// The C API of results: one of several shards, comparison, tables.
#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "api/c_error.h"
#include "api/c_text.h"
#include "engram/engram_c.h"
#include "protocol/eval/merged_evaluation.h"
#include "protocol/eval/results/comparison.h"
#include "protocol/eval/results/result_tables.h"
#include "protocol/make/environment_files.h"

namespace {

using engram::Error;
using engram::c::guarded;

[[noreturn]] void refuse_results(const std::string& what) {
  throw Error(Error::kInvalidArgument, what);
}

std::string merge(const std::vector<std::filesystem::path>& folders, const char* output) {
  engram::load_environment_files();
  const engram::ShardSet shards(folders);
  const std::filesystem::path first = shards.parts().front().folder;
  if (shards.header().kind != engram::kEvaluationKind) {
    refuse_results("'" + first.string() + "' is of a run of '" + shards.header().kind +
                   "', which `engram merge` makes one result of; shards of evaluations needed");
  }
  const std::vector<engram::MissingShard> missing = shards.missing();
  if (!missing.empty()) {
    throw Error(Error::kUnavailable, std::to_string(missing.size()) + " of " +
                                         std::to_string(shards.header().shard->count) +
                                         " shards not finished; the first is " +
                                         to_text(missing.front().shard) + ", without " +
                                         std::to_string(missing.front().episodes) + " episodes");
  }
  const std::filesystem::path out =
      output != nullptr ? output : std::filesystem::canonical(first).parent_path();
  return engram::to_text(merge_evaluation(shards, out, {}).document());
}

}  // namespace

engram_status engram_merge(const char* const* folders, size_t num_folders, const char* output,
                           char** document) {
  if (document != nullptr) *document = nullptr;
  return guarded([&] {
    if (folders == nullptr || document == nullptr)
      refuse_results("engram_merge: a null pointer given");
    if (num_folders == 0) refuse_results("folders: none given, 1 or more needed");
    if (output != nullptr && *output == '\0') refuse_results("output: '' given, a text needed");
    std::vector<std::filesystem::path> paths;
    for (size_t i = 0; i < num_folders; ++i) {
      if (folders[i] == nullptr) refuse_results("engram_merge: a null pointer given");
      paths.emplace_back(folders[i]);
    }
    *document = engram::c::new_text(merge(paths, output));
  });
}

engram_status engram_compare(const char* a, const char* b, const char* const* allowed,
                             size_t num_allowed, char** document) {
  if (document != nullptr) *document = nullptr;
  return guarded([&] {
    if (a == nullptr || b == nullptr || document == nullptr ||
        (allowed == nullptr && num_allowed > 0)) {
      refuse_results("engram_compare: a null pointer given");
    }
    std::set<engram::AllowedDifference> differences;
    for (std::size_t i = 0; i < num_allowed; ++i) {
      if (allowed[i] == nullptr) refuse_results("engram_compare: a null pointer given");
      differences.insert(
          engram::require_named<engram::AllowedDifference>("allowed difference", allowed[i]));
    }
    *document = engram::c::new_text(engram::to_text(
        engram::compare_results(engram::read_results(a), engram::read_results(b), differences)));
  });
}

engram_status engram_report(const char* results, const char* format, char** table) {
  if (table != nullptr) *table = nullptr;
  return guarded([&] {
    if (results == nullptr || format == nullptr || table == nullptr) {
      refuse_results("engram_report: a null pointer given");
    }
    *table = engram::c::new_text(
        engram::result_table(engram::require_named<engram::TableFormat>("format", format),
                             engram::read_results(results).tasks));
  });
}
