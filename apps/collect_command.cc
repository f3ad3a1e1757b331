#include "apps/collect_command.h"

#include <fmt/format.h>

#include <chrono>
#include <limits>
#include <memory>
#include <numeric>

#include "apps/collect_estimate.h"
#include "apps/interruption.h"
#include "apps/mpi_run.h"
#include "apps/options.h"
#include "apps/output.h"
#include "apps/progress.h"
#include "apps/task_choice.h"
#include "protocol/datasets/collection.h"
#include "protocol/datasets/collection_report.h"
#include "protocol/formats/document.h"
#include "protocol/formats/files.h"

namespace engram::apps {
namespace {

constexpr const char* kReport = "collect_report.html";

struct CollectOptions {
  std::vector<std::string> ids;
  TaskFilter filter;
  bool all = false;
  ImageSourceOptions images;
  std::string out = ".";
  CollectionOptions collection{.plan = {}, .out = {}};
  bool estimate = false;
  bool json = false;
};

DocumentTable task_document(const DemonstrationFolder& folder) {
  return {{"env_id", folder.entry().id},   {"out", folder.path().string()},
          {"episodes", folder.episodes()}, {"steps", folder.steps()},
          {"attempts", folder.attempts()}, {"keep_rate", keep_rate(folder)}};
}

using Folders = std::vector<std::unique_ptr<DemonstrationFolder>>;

DocumentTable document(const Folders& folders, const CollectOptions& options) {
  int episodes = 0;
  std::int64_t steps = 0;
  DocumentList tasks;
  for (const auto& folder : folders) {
    episodes += folder->episodes();
    steps += folder->steps();
    tasks.emplace_back(task_document(*folder));
  }
  return {{"out", options.collection.out.string()},
          {"format", "npz"},
          {"episodes", episodes},
          {"steps", steps},
          {"tasks", tasks}};
}

std::string to_plain_text(const Folders& folders) {
  Table table({{"task"},
               {"episodes", true},
               {"steps", true},
               {"mean steps", true},
               {"attempts", true},
               {"kept", true},
               {"folder"}});
  for (const auto& folder : folders) {
    const double mean =
        folder->episodes() == 0 ? 0.0 : static_cast<double>(folder->steps()) / folder->episodes();
    table.add({std::string(folder->entry().id), std::to_string(folder->episodes()),
               with_thousands(static_cast<double>(folder->steps())), fmt::format("{:.1f}", mean),
               std::to_string(folder->attempts()), fmt::format("{:.3f}", keep_rate(*folder)),
               folder->path().string()});
  }
  return table.text();
}

// Too few episodes are a failure, although those collected are kept.
void require_complete(const Folders& folders, const CollectionPlan& plan) {
  for (const auto& folder : folders) {
    if (folder->complete()) continue;
    throw Error(
        Error::kUnavailable,
        fmt::format("{}: {} of {} episodes after {} attempts; more --max-attempts allowed",
                    folder->entry().id, folder->episodes(), plan.episodes, plan.max_attempts));
  }
}

Folders collect_all(Ranks& ranks, const std::vector<const RegistryEntry*>& tasks,
                    const CollectOptions& options, CollectionTiming& timing) {
  Progress progress("collect", "steps");
  const Interruption interruption;
  const auto start = std::chrono::steady_clock::now();
  Folders folders = collect(ranks, tasks, options.collection, [&](const CollectionProgress& now) {
    progress.update(static_cast<double>(now.episodes) / now.wanted,
                    static_cast<double>(now.env_steps));
    timing.episodes = now.added;
    timing.env_steps = now.env_steps;
    interruption.check(
        fmt::format("{} of {} episodes are in '{}'; the same command goes on with the others",
                    now.episodes, now.wanted, options.collection.out.string()));
  });
  timing.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return folders;
}

void run(Ranks& ranks, CollectOptions& options) {
  const std::vector<const RegistryEntry*> tasks =
      chosen_tasks(options.ids, options.filter, options.all);
  options.collection.plan.renderer = options.images.renderer;
  options.collection.out = options.out;
  if (options.estimate) {
    if (!ranks.is_root()) return;
    const Interruption interruption;
    const CollectEstimate estimate = estimate_collection(tasks, options.collection, interruption);
    print(options.json ? to_text(estimate.document()) : estimate.text());
    return;
  }
  CollectionTiming timing;
  if (ranks.is_root()) {
    MakeOptions env;
    env.rules = options.collection.plan.rules;
    env.constants = options.collection.plan.constants;
    warn_of_unused_constants(tasks, env);
  }
  const Folders folders = collect_all(ranks, tasks, options, timing);
  if (!ranks.is_root()) return;
  write_output(options.collection.out / kReport, collection_report(folders, timing));
  print(options.json ? to_text(document(folders, options)) : to_plain_text(folders));
  require_complete(folders, options.collection.plan);
}

}  // namespace

void add_collect_command(const Command& program) {
  const auto options = std::make_shared<CollectOptions>();
  const Command command =
      program.add_command("collect", "Demonstrations of the oracle, as NPZ files");
  command.add_option("ids", options->ids, "Tasks, such as RememberColor9-VLA-v0").type_name("ID");
  add_filter(command, options->filter);
  command.add_flag("--canonical", options->filter.canonical, "Tasks of the benchmark proper only");
  command.add_flag("--all", options->all, "All registered tasks that pass the filters");
  CollectionPlan& plan = options->collection.plan;
  add_int(command, "--episodes", plan.episodes, 1, std::numeric_limits<int>::max(),
          "Episodes per task");
  add_int(command, "--max-attempts", plan.max_attempts, 1, 100'000'000,
          "Attempts per task, of one episode or one batch");
  add_seed(command, plan.start_seed, "The first episode's; those after it follow one by one");
  add_renderer(command, options->images);
  command.add_flag(
      "--labels", plan.labels,
      "Also subtasks, plan and memory in words, keyframes, progress, and where cameras "
      "see the object that is meant: privileged");
  add_constants(command, plan.constants);
  add_rules(command, plan.rules);
  add_num_envs(command, options->collection.num_envs);
  add_threads(command, options->collection.threads);
  command.add_option("--out", options->out, "Folder to hold data_npz/<ID>")
      .type_name("DIR")
      .default_str(options->out);
  command.add_flag(
      "--estimate", options->estimate,
      "Plays the first attempts of each task only, says how large the files will be and "
      "how long they take, and writes nothing");
  add_json(command, options->json);
  command.footer(
      "Keeps episodes that succeed, up to their first success. After an interruption, the same "
      "command continues. Files do not depend on --num-envs, --threads or the number of "
      "processes.");
  command.on_run([options] { with_mpi([&](Ranks& ranks) { run(ranks, *options); }); });
}

}  // namespace engram::apps
