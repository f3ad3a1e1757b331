// The result files of an evaluation (docs/evaluation.md): <ID>.json of every finished task,
// summary.json, settings.json, with which an interrupted run is resumed, and a report.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "protocol/eval/run/settings.h"
#include "protocol/io/folder_lock.h"

namespace engram {

// The policy: name and configuration.
Json model_document(const EvaluationSettings& settings);
// The benchmark's result document of a task, with its keys in its order, and the chance level.
Json task_document(const TaskResult& result, const EvaluationSettings& settings);
// The document of a sealed run with what the opened settings tell: secret and seeds.
Json revealed_document(const Json& task, const EvaluationSettings& revealed);
// Summary of task documents in the registry's order.
Json summary_document(const JsonList& tasks);

// The settings that the run of a folder began with; nothing if their file is missing. Throws Error
// as EvaluationSettings::of does.
std::optional<EvaluationSettings> settings_in(const OpenFolder& folder);

// The folder of a run, which keeps other runs from it. Files appear whole or not at all.
class ResultFolder {
 public:
  // Makes <output>/<split>/<date and time>/. Throws Error (kIo) if that fails.
  static ResultFolder create(const std::filesystem::path& output,
                             const EvaluationSettings& settings);
  // Opens or makes <output>/shard-I-of-N/. Throws Error (kIo) if that fails, or another run is at
  // work in it.
  static ResultFolder of_shard(const std::filesystem::path& output, const Shard& shard);
  // Opens the folder of an interrupted run. Throws Error (kIo) if it does not exist, or another run
  // is at work in it.
  static ResultFolder open(const std::filesystem::path& folder);

  const std::filesystem::path& path() const { return path_; }
  const OpenFolder& files() const { return lock_->folder(); }
  std::optional<EvaluationSettings> settings() const { return settings_in(files()); }
  // Finished tasks, by id. Damaged and edited files are ignored. Throws Error (kInvalidArgument)
  // for intact results of another protocol.
  std::map<std::string, Json> finished(const EvaluationSettings& settings) const;

  // Writes the settings, so that the run can be resumed.
  void begin(const EvaluationSettings& settings) const;
  void write_task(const Json& task) const;
  void write_summary(const JsonList& tasks) const;
  void write_episodes(const JsonList& tasks) const;

  // For the report alone, beside the results: time by task id, in timing.json, and images, in
  // samples/<ID>.png.
  void add_timing(const std::string& id, double thread_seconds) const;
  std::map<std::string, double> timing() const;
  void write_sample(const std::string& id, const Bytes& png) const;
  std::map<std::string, Bytes> samples() const;
  void write_report(const std::string& html) const;

 private:
  explicit ResultFolder(std::filesystem::path path);

  std::filesystem::path path_;
  std::shared_ptr<const FolderLock> lock_;  // copies are of the same run
};

// The ids' split in lower case, "all" where they differ.
std::string common_split(const std::vector<std::string>& ids);

}  // namespace engram
