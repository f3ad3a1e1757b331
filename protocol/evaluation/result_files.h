// The result files of an evaluation (common 12.2): <ID>.json of every finished task, summary.json,
// settings.json, with which an interrupted run is resumed, and a report.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "protocol/evaluation/evaluate.h"
#include "protocol/formats/document.h"

namespace engram {

// What a run was asked for, as far as results depend on it.
struct EvaluationSettings {
  std::vector<std::string> tasks;  // ids, in the registry's order
  int episodes = 50;
  std::uint64_t start_seed = 4242424242;
  std::string obs_mode = "rgb";
  std::string renderer = "none";  // of rgb observations
  std::string policy;             // "oracle", or the name of an external one
  Document policy_config;         // what else there is to say of it
  std::map<std::string, double> task_options;

  Document document() const;
  // Throws Error (kIo) if the document is not one of settings.
  static EvaluationSettings of(const Document& document, const std::filesystem::path& file);
};

// The documents of common 12.2, with its keys in its order, and the chance level.
Document task_document(const TaskResult& result, const EvaluationSettings& settings);
// Of task documents, in the registry's order.
Document summary_document(const DocumentList& tasks);

// The folder of a run. Files appear whole or not at all.
class ResultFolder {
 public:
  // Makes <output>/<split>/<date and time>/. Throws Error (kIo) if that fails.
  static ResultFolder create(const std::filesystem::path& output,
                             const EvaluationSettings& settings);
  // Opens one to go on with. Throws Error (kIo) if there is none.
  static ResultFolder open(const std::filesystem::path& folder);

  const std::filesystem::path& path() const { return path_; }
  // The settings with which it was begun, if there are any.
  std::optional<EvaluationSettings> settings() const;
  // Finished tasks, by id. Damaged files count as not there. Throws Error (kInvalidArgument) for
  // results that are whole but of another protocol.
  std::map<std::string, Document> finished(const EvaluationSettings& settings) const;

  // Settings, so that the run can be resumed.
  void begin(const EvaluationSettings& settings) const;
  void write_task(const Document& task) const;
  void write_summary(const DocumentList& tasks) const;

  // What the report needs and results must not depend on: time, by task id, in timing.json, and
  // pictures in samples/<ID>.png.
  void add_timing(const std::string& id, double thread_seconds) const;
  std::map<std::string, double> timing() const;
  void write_sample(const std::string& id, const Bytes& png) const;
  std::map<std::string, Bytes> samples() const;
  void write_report(const std::string& html) const;

 private:
  explicit ResultFolder(std::filesystem::path path) : path_(std::move(path)) {}

  std::filesystem::path path_;
};

// The ids' split in lower case, "all" where they differ.
std::string common_split(const std::vector<std::string>& ids);

}  // namespace engram
