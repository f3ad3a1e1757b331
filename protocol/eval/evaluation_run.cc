#include "protocol/eval/evaluation_run.h"

#include "protocol/eval/results/evaluation_report.h"

namespace engram {

EvaluationRun::EvaluationRun(EvaluationSettings settings, std::optional<ResultFolder> folder)
    : settings_(std::move(settings)), folder_(std::move(folder)) {
  if (!folder_) return;
  finished_ = folder_->finished(settings_);
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
  if (!settings_.tells_seeds() && !keep_sealed) open();
  if (!folder_) return;
  // Again: an earlier process may have been killed between a result and its summary.
  folder_->write_summary(tasks());
  folder_->write_episodes(tasks());
  const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - start_;
  folder_->write_report(evaluation_report(settings_, tasks(), folder_->timing(), folder_->samples(),
                                          {compute, wall.count()}));
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

}  // namespace engram
