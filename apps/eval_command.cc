#include "apps/eval_command.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <limits>
#include <memory>

#include "apps/evaluation.h"
#include "apps/options.h"
#include "apps/output.h"
#include "apps/progress.h"
#include "protocol/files.h"

namespace engram::apps {
namespace {

struct EvalOptions {
  std::vector<std::string> ids;
  TaskFilter filter;
  bool all = false;
  Protocol protocol;
  bool json = false;
  std::string out;
};

// The tasks by name; an unknown or unavailable one is an error.
std::vector<const RegistryEntry*> named_tasks(const std::vector<std::string>& ids) {
  std::vector<const RegistryEntry*> tasks;
  for (const std::string& id : ids) {
    const RegistryEntry& entry = require_entry(id);
    if (!is_implemented(entry)) (void)make_task(id);  // throws, saying why
    if (std::find(tasks.begin(), tasks.end(), &entry) == tasks.end()) tasks.push_back(&entry);
  }
  return tasks;
}

std::vector<const RegistryEntry*> chosen_tasks(const EvalOptions& options) {
  const bool filtered = options.all || options.filter.any();
  if (!options.ids.empty() && filtered) {
    throw Error(Error::kInvalidArgument,
                "task ids and --split, --family, --canonical or --all given; one or the other "
                "allowed");
  }
  if (options.ids.empty() && !filtered) {
    throw Error(Error::kInvalidArgument,
                "no task given; ids, --split, --family, --canonical or --all needed");
  }
  if (!filtered) return named_tasks(options.ids);

  std::vector<const RegistryEntry*> tasks = select(options.filter);
  const std::size_t registered = tasks.size();
  std::erase_if(tasks, [](const RegistryEntry* entry) { return !is_implemented(*entry); });
  if (tasks.empty()) {
    throw Error(Error::kUnavailable,
                fmt::format("{} tasks chosen, none of a family that is part of this version; "
                            "`engram list` shows which are",
                            registered));
  }
  if (tasks.size() < registered) {
    print_error(fmt::format("{} of {} tasks skipped: their families are not part of this version",
                            registered - tasks.size(), registered));
  }
  return tasks;
}

void save(const std::filesystem::path& folder, const std::vector<TaskResult>& results,
          const Protocol& protocol) {
  const std::string id(results.back().entry->id);
  write_file(folder / (id + ".json"), to_text(task_document(results.back(), protocol)));
  write_file(folder / "summary.json", to_text(summary_document(results)));
}

std::string to_words(const std::vector<TaskResult>& results) {
  Table table({{"task"},
               {"split"},
               {"memory type"},
               {"success_once", true},
               {"chance", true},
               {"mean return", true},
               {"mean steps", true}});
  for (const TaskResult& result : results) {
    table.add({std::string(result.entry->id), std::string(split_name(result.entry->split)),
               std::string(result.entry->memory_type), fmt::format("{:.3f}", result.success_rate()),
               fmt::format("{:.3f}", result.chance), fmt::format("{:.2f}", result.mean_return()),
               fmt::format("{:.1f}", result.mean_length())});
  }
  const Json summary = summary_document(results);
  std::string text = table.text() + fmt::format("mean over {} tasks: {:.3f}\n", results.size(),
                                                summary["sr_split"].get<double>());
  for (const auto& [type, rate] : summary["sr_per_memory_type"].items()) {
    text += fmt::format("  {}: {:.3f}\n", type, rate.get<double>());
  }
  return text;
}

void run(const EvalOptions& options) {
  const std::vector<const RegistryEntry*> tasks = chosen_tasks(options);
  if (!options.out.empty()) require_writable_folder(options.out);
  std::vector<TaskResult> results;
  std::uint64_t unstable = 0;
  {
    Progress progress("eval", "");
    for (const RegistryEntry* task : tasks) {
      const auto done = static_cast<double>(results.size());
      const auto count = static_cast<double>(tasks.size());
      results.push_back(evaluate(*task, options.protocol, [&](double fraction) {
        progress.update((done + fraction) / count);
      }));
      unstable += results.back().unstable;
      if (!options.out.empty()) save(options.out, results, options.protocol);
    }
  }
  if (unstable > 0) {
    print_error(
        fmt::format("physics diverged in {} steps; their episodes were cut short", unstable));
  }
  if (!options.json) {
    print(to_words(results));
    return;
  }
  Json document = {{"summary", summary_document(results)}, {"tasks", Json::array()}};
  for (const TaskResult& result : results) {
    document["tasks"].push_back(task_document(result, options.protocol));
  }
  print(to_text(document));
}

}  // namespace

void add_eval_command(CLI::App& app) {
  static constexpr Policy kPolicies[] = {Policy::kOracle, Policy::kBlind, Policy::kZero,
                                         Policy::kRandom};
  const auto options = std::make_shared<EvalOptions>();
  CLI::App* command =
      app.add_subcommand("eval", "Success rates by the benchmark's evaluation protocol");
  command->add_option("ids", options->ids, "Tasks, such as RememberColor9-VLA-v0")->type_name("ID");
  add_filter(*command, options->filter);
  command->add_flag("--canonical", options->filter.canonical, "Tasks of the benchmark proper only");
  command->add_flag("--all", options->all, "All registered tasks that pass the filters");
  add_policy(*command, options->protocol.policy, kPolicies);
  add_int(*command, "--episodes", options->protocol.episodes, 1, std::numeric_limits<int>::max(),
          "Episodes per task");
  add_seed(*command, options->protocol.start_seed, "Episode i has seed + i");
  add_num_envs(*command, options->protocol.num_envs);
  add_obs(*command, options->protocol.observation);
  add_threads(*command, options->protocol.threads);
  add_json(*command, options->json);
  command
      ->add_option("--out", options->out,
                   "Folder for <ID>.json of every task and summary.json, written as they finish")
      ->type_name("DIR");
  command->footer(
      "One episode per seed, until it is terminated or as long as its horizon; success_once is the "
      "share of episodes with success in any step. Results do not depend on --num-envs or "
      "--threads.");
  command->final_callback([options] { run(*options); });
}

}  // namespace engram::apps
