#include "apps/eval_command.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <memory>
#include <optional>

#include "apps/eval_options.h"
#include "apps/output.h"
#include "apps/progress.h"

namespace engram::apps {
namespace {

std::string to_words(const std::vector<Json>& tasks) {
  Table table({{"task"},
               {"split"},
               {"memory type"},
               {"success_once", true},
               {"chance", true},
               {"mean return", true},
               {"mean steps", true}});
  std::map<std::string, std::vector<double>> splits;
  for (const Json& task : tasks) {
    const auto lengths = task["episode_lengths"].get<std::vector<double>>();
    double steps = 0;
    for (const double length : lengths) steps += length / static_cast<double>(lengths.size());
    const double rate = task["sr"].get<double>();
    splits[task["split"].get<std::string>()].push_back(rate);
    table.add({task["env_id"].get<std::string>(), task["split"].get<std::string>(),
               task["memory_type"].get<std::string>(), fmt::format("{:.3f}", rate),
               fmt::format("{:.3f}", task["chance"].get<double>()),
               fmt::format("{:.2f}", task["mean_return"].get<double>()),
               fmt::format("{:.1f}", steps)});
  }
  const Json summary = summary_document(tasks);
  std::string text = table.text() + fmt::format("mean over {} tasks: {:.3f}\n", tasks.size(),
                                                summary["sr_split"].get<double>());
  for (const auto& [split, rates] : splits) {
    double sum = 0;
    for (const double rate : rates) sum += rate;
    text += fmt::format("  split {}: {:.3f} over {} tasks\n", split,
                        sum / static_cast<double>(rates.size()), rates.size());
  }
  for (const auto& [type, rate] : summary["sr_per_memory_type"].items()) {
    text += fmt::format("  {}: {:.3f}\n", type, rate.get<double>());
  }
  return text;
}

// The run as rank 0 sees it: what is to be done, and what has been.
class Run {
 public:
  explicit Run(const EvalOptions& options) : options_(options) {
    if (options.resume.empty()) {
      settings_ = settings_of(options);
      if (!options.out.empty()) folder_ = ResultFolder::create(options.out, settings_);
    } else {
      folder_ = ResultFolder::open(options.resume);
      settings_ = resumed_settings(options, *folder_);
      finished_ = folder_->finished(settings_);
    }
    if (folder_) folder_->begin(settings_);
  }

  const EvaluationSettings& settings() const { return settings_; }

  std::vector<const RegistryEntry*> open_tasks() const {
    std::vector<const RegistryEntry*> tasks;
    for (const std::string& id : settings_.tasks) {
      if (!finished_.contains(id)) tasks.push_back(&require_entry(id));
    }
    return tasks;
  }

  void add(const TaskResult& result) {
    Json document = task_document(result, settings_);
    if (folder_) folder_->write_task(document);
    finished_.emplace(result.entry->id, std::move(document));
    unstable_ += result.unstable;
    if (folder_) folder_->write_summary(documents());
  }

  void finish() const {
    // Once more: the last one may be older than the last result, if its process was killed.
    if (folder_) folder_->write_summary(documents());
    if (unstable_ > 0) {
      print_error(
          fmt::format("physics diverged in {} steps; their episodes were cut short", unstable_));
    }
    const std::vector<Json> tasks = documents();
    if (options_.json) {
      print(to_text(Json{{"summary", summary_document(tasks)}, {"tasks", tasks}}));
    } else {
      print(to_words(tasks));
      if (folder_) print(fmt::format("results: {}\n", folder_->path().string()));
    }
  }

 private:
  // In the registry's order.
  std::vector<Json> documents() const {
    std::vector<Json> documents;
    for (const RegistryEntry& entry : registry()) {
      const auto found = finished_.find(std::string(entry.id));
      if (found != finished_.end()) documents.push_back(found->second);
    }
    return documents;
  }

  const EvalOptions& options_;
  EvaluationSettings settings_;
  std::optional<ResultFolder> folder_;
  std::map<std::string, Json> finished_;
  std::uint64_t unstable_ = 0;
};

void lead(Ranks& ranks, const EvalOptions& options) {
  Run run(options);
  const std::string settings = to_text(run.settings().document());
  const auto bytes = std::as_bytes(std::span(settings.data(), settings.size()));
  share(ranks, {bytes.begin(), bytes.end()});
  const std::vector<const RegistryEntry*> tasks = run.open_tasks();
  {
    Progress progress("eval", "steps");
    const double episodes = static_cast<double>(tasks.size()) * run.settings().episodes;
    evaluate(ranks, tasks, protocol_of(options, run.settings()),
             {.finished = [&](const TaskResult& result) { run.add(result); },
              .tick =
                  [&](const EvaluationStatus& status) {
                    progress.update(status.episodes / episodes,
                                    static_cast<double>(status.env_steps));
                  }});
  }
  run.finish();
}

void follow(Ranks& ranks, const EvalOptions& options) {
  const Bytes bytes = share(ranks, {});
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  const EvaluationSettings settings = EvaluationSettings::of(Json::parse(text), "settings");
  evaluate(ranks, {}, protocol_of(options, settings), {});
}

void run(const EvalOptions& options) {
  const std::unique_ptr<Ranks> ranks = join_ranks();
  try {
    if (ranks->leads()) {
      lead(*ranks, options);
    } else {
      follow(*ranks, options);
    }
  } catch (const std::exception& error) {
    if (!ranks->alone()) {
      print_error(error.what());
      ranks->abort();
    }
    throw;
  }
}

}  // namespace

void add_eval_command(CLI::App& app) {
  const auto options = std::make_shared<EvalOptions>();
  CLI::App* command =
      app.add_subcommand("eval", "Success rates by the benchmark's evaluation protocol");
  add_eval_options(*command, *options);
  command->final_callback([options] { run(*options); });
}

}  // namespace engram::apps
