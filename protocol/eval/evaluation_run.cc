#include "protocol/eval/evaluation_run.h"

#include "protocol/eval/results/evaluation_report.h"

namespace engram {

EvaluationRun::EvaluationRun(EvaluationSettings settings, std::optional<ResultFolder> folder,
                             EpisodePart part)
    : settings_(std::move(settings)),
      folder_(std::move(folder)),
      part_(std::move(part)),
      identity_(std::make_shared<PolicyIdentity>(folder_)) {
  if (!folder_) return;
  finished_ = folder_->finished(settings_);
  // A run that is killed while it opens its results is the same run.
  EvaluationSettings sealed = settings_;
  sealed.revealed = false;
  RunHeader header{.kind = kEvaluationKind,
                   .shard = part_.shard,
                   .command = part_.command,
                   .run = sealed.document(),
                   .tasks = {}};
  std::vector<const RegistryEntry*> tasks;
  for (const std::string& id : settings_.tasks) tasks.push_back(&require_entry(id));
  const std::vector<TaskLoad> loads = loads_of(tasks, settings_);
  for (std::size_t i = 0; i < tasks.size(); ++i) {
    header.tasks.push_back({settings_.tasks[i], loads[i]});
  }
  journal_ = std::make_unique<Journal>(folder_->files(), header.document());
  folder_->begin(settings_);
}

std::vector<const RegistryEntry*> EvaluationRun::open_tasks() const {
  std::vector<const RegistryEntry*> tasks;
  for (const std::string& id : settings_.tasks) {
    if (!finished_.contains(id)) tasks.push_back(&require_entry(id));
  }
  return tasks;
}

void EvaluationRun::add(const TaskResult& result) {
  if (part_.shard) return;
  Json document = task_document(result, settings_);
  if (folder_) {
    // The result comes last: a task that has one is complete.
    folder_->write_sample(std::string(result.entry->id), result.sample);
    folder_->add_timing(std::string(result.entry->id), result.thread_seconds);
    folder_->write_task(document);
  }
  finished_.emplace(result.entry->id, std::move(document));
  unstable_ += result.unstable;
  if (folder_) folder_->write_summary(tasks());
}

// Only now may anybody know the seeds. The settings come last: until then the run can be resumed.
void EvaluationRun::open() {
  settings_.revealed = true;
  for (auto& [id, document] : finished_) {
    document = revealed_document(document, settings_);
    if (folder_) folder_->write_task(document);
  }
  if (folder_) folder_->begin(settings_);
}

void EvaluationRun::finish(const std::string& compute, bool keep_sealed) {
  if (part_.shard) return;
  if (!settings_.tells_seeds() && !keep_sealed) open();
  if (!folder_) return;
  // Again: an earlier process may have been killed between a result and its summary.
  folder_->write_summary(tasks());
  folder_->write_episodes(tasks());
  const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - start_;
  folder_->write_report(evaluation_report(settings_, tasks(), folder_->timing(), folder_->samples(),
                                          {compute, wall.count()}));
  journal_->remove();
}

JsonList EvaluationRun::tasks() const {
  JsonList documents;
  for (const RegistryEntry* entry : all_entries()) {
    const auto found = finished_.find(std::string(entry->id));
    if (found != finished_.end()) documents.push_back(found->second);
  }
  return documents;
}

Json EvaluationRun::document() const {
  const JsonList documents = tasks();
  return JsonTable{{"summary", summary_document(documents)}, {"tasks", documents}};
}

JsonTable EvaluationRun::shard_document() const {
  return {{"shard", to_text(part_.shard.value_or(Shard()))},
          {"out", folder_->path().string()},
          {"episodes", journaled()}};
}

}  // namespace engram
