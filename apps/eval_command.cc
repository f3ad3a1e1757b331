#include "apps/eval_command.h"

#include <fmt/format.h>
#include <sys/prctl.h>

#include <algorithm>
#include <map>
#include <memory>
#include <optional>

#include "apps/eval_options.h"
#include "apps/eval_sweep.h"
#include "apps/interruption.h"
#include "apps/live_view.h"
#include "apps/mpi_run.h"
#include "apps/output.h"
#include "apps/task_choice.h"
#include "protocol/eval/evaluation_run.h"
#include "protocol/eval/results/success_rates.h"
#include "protocol/io/html.h"
#include "protocol/parallel/run_header.h"

namespace engram::apps {
namespace {

std::string with_interval(const SuccessRate& rate) {
  return fmt::format("{:.3f} ({})", rate.rate, to_text(rate.interval));
}

std::string to_plain_text(const JsonList& tasks) {
  Table rows({{"task"},
              {"split"},
              {"memory type"},
              {"success_once", true},
              {"95 % interval", true},
              {"chance", true},
              {"score", true},
              {"first answer", true},
              {"mean return", true},
              {"mean steps", true}});
  for (const Json& task : tasks) {
    const JsonList& lengths = list(part(task, "episode_lengths"));
    double steps = 0;
    for (const Json& length : lengths) {
      steps += number(length) / static_cast<double>(lengths.size());
    }
    const SuccessRate rate = success_rate(task);
    const auto share = [&task](const char* key) {
      const Json& value = part(task, key);
      return is_null(value) ? std::string("-") : fmt::format("{:.3f}", number(value));
    };
    rows.add(
        {text(part(task, "env_id")), text(part(task, "split")), text(part(task, "memory_type")),
         fmt::format("{:.3f}", rate.rate), to_text(rate.interval), share("chance"),
         share("memory_score"), share("first_answer_correct"),
         fmt::format("{:.2f}", number(part(task, "mean_return"))), fmt::format("{:.1f}", steps)});
  }
  std::string lines = rows.text() + fmt::format("mean over {}: {}\n", counted(tasks.size(), "task"),
                                                with_interval(mean_success_rate(tasks)));
  for (const auto& [split, rate] : success_rates_by("split", tasks)) {
    lines += fmt::format("  split {}: {} over {}\n", split, with_interval(rate),
                         counted(static_cast<std::size_t>(rate.tasks), "task"));
  }
  for (const auto& [type, rate] : success_rates_by("memory_type", tasks)) {
    lines += fmt::format("  {}: {}\n", type, with_interval(rate));
  }
  return lines;
}

std::string compute_text(const Ranks& ranks, int threads) {
  const std::string each = counted(static_cast<std::size_t>(threads), "thread");
  return ranks.is_single() ? "CPU, " + each
                           : fmt::format("CPU, {} processes of {}", ranks.size(), each);
}

// --- the run ---

// Goes on with the run of the folder, which may be a shard.
EvaluationRun begin_again(const EvalOptions& options) {
  ResultFolder folder = ResultFolder::open(options.resume);
  EvaluationSettings settings = resumed_settings(options, folder.settings(), folder.path());
  EpisodePart part{.shard = {}, .command = words_of_command()};
  if (const auto journal = read_journal(folder.files())) {
    part.shard = RunHeader::of(journal->header, folder.path() / kJournalFile).shard;
  }
  return {std::move(settings), std::move(folder), std::move(part)};
}

EvaluationRun begin(const EvalOptions& options) {
  require_folder(options.control, options.out);
  if (!options.resume.empty()) return begin_again(options);
  EvaluationSettings settings = settings_of(options);
  if (options.out.empty()) return {std::move(settings), std::nullopt};
  ResultFolder folder = options.control.shard
                            ? ResultFolder::of_shard(options.out, *options.control.shard)
                            : ResultFolder::create(options.out, settings);
  return {std::move(settings),
          std::move(folder),
          {.shard = options.control.shard, .command = words_of_command()}};
}

// What is left of an interrupted run, and how to go on.
std::string state_of(const EvaluationRun& run) {
  if (!run.folder()) return "no results were written";
  const std::string folder = run.folder()->path().string();
  return fmt::format(
      "finished episodes are in '{}'; {} goes on with the others", folder,
      run.shard() ? "the same command" : shell_line({"engram", "eval", "--resume", folder}));
}

void show(LiveView& view, const EvaluationStatus& status, const EvaluationRun& run,
          std::size_t tasks) {
  if (!view.due()) return;
  const int episodes = run.settings().all_episodes();
  std::vector<LiveView::TaskProgress> rows;
  double under_way = 0;
  for (const EvaluationStatus::Running& task : status.running) {
    const double fraction = static_cast<double>(task.episodes) / episodes;
    under_way += fraction / static_cast<double>(status.running.size());
    rows.push_back({std::string(task.entry->id), fraction,
                    fmt::format("{} of {} episodes", task.episodes, episodes)});
  }
  view.draw({{"episodes", status.episodes / std::max(1.0, static_cast<double>(status.wanted)),
              fmt::format("{} of {}, {} steps", status.episodes, status.wanted,
                          with_thousands(static_cast<double>(status.env_steps)))},
             {"now", under_way, fmt::format("{} of {} tasks finished", status.tasks, tasks)}},
            rows);
}

// Keeps processes of the same user, such as policies, from reading the memory and descriptors of a
// sealed run. Throws Error where that cannot be done.
void conceal_memory(const Ranks& ranks) {
  if (!ranks.is_single()) {
    throw Error(Error::kInvalidArgument,
                fmt::format("--seed-file: {} processes of MPI given, 1 allowed; others of the same "
                            "user can read what they send to one another",
                            ranks.size()));
  }
  if (::prctl(PR_SET_DUMPABLE, 0) != 0) {
    throw Error(Error::kUnavailable,
                "--seed-file: this system keeps no memory from other "
                "processes of the same user");
  }
}

// Plays what is missing of a run.
EvaluationRun run_coordinator(Ranks& ranks, const EvalOptions& options) {
  EvaluationRun run = begin(options);
  broadcast(ranks, run.settings().document());
  const std::vector<const RegistryEntry*> tasks = run.open_tasks();
  Protocol protocol = protocol_of(options, run.settings(), run.identity());
  warn_of_constants(tasks, protocol.environment);
  {
    LiveView view;
    const Interruption interruption(Interruption::kGraceSeconds, options.control.time_limit);
    const std::string state = state_of(run);
    evaluate(ranks, tasks, protocol,
             {.finished = [&run](const TaskResult& result) { run.add(result); },
              .tick =
                  [&](const EvaluationStatus& status) {
                    interruption.check(state);
                    show(view, status, run, tasks.size());
                  }},
             run.store());
  }
  run.finish(compute_text(ranks, worker_threads(protocol.threads, ranks)), options.keep_sealed);
  if (run.unstable() > 0) {
    print_error(
        fmt::format("physics diverged in {} steps; their episodes were cut short", run.unstable()));
  }
  return run;
}

void run_worker(Ranks& ranks, const EvalOptions& options) {
  const EvaluationSettings settings =
      EvaluationSettings::of(broadcast(ranks, Json()), "settings of rank 0");
  const Interruption interruption;  // rank 0 says what is saved, and ends all
  evaluate(ranks, {}, protocol_of(options, settings), {});
}

void run_eval(Ranks& ranks, const EvalOptions& options) {
  // Before there is anything to conceal.
  if (ranks.is_root() && !options.seed_file.empty()) conceal_memory(ranks);
  const std::vector<SweepPoint> points = sweep_of(options);
  JsonList documents;
  for (const SweepPoint& point : points) {
    if (!ranks.is_root()) {
      run_worker(ranks, point.options);
      continue;
    }
    const EvaluationRun run = run_coordinator(ranks, point.options);
    if (run.shard()) {
      print_shard(*run.shard(), run.folder()->path(), run.journaled(), options.json);
    } else if (points.size() == 1) {
      print_results(run, options.json);
    } else {
      documents.push_back(point_document(point, run.document()));
    }
  }
  if (!documents.empty()) print(options.json ? to_text(documents) : sweep_text(documents));
}

}  // namespace

void print_results(const EvaluationRun& run, bool json) {
  if (json) {
    print(to_text(run.document()));
    return;
  }
  print(to_plain_text(run.tasks()));
  if (run.folder()) print(fmt::format("results: {}\n", run.folder()->path().string()));
}

void add_eval_command(const Command& program) {
  const auto options = std::make_shared<EvalOptions>();
  const Command command =
      program.add_command("eval", "Success rates by the benchmark's evaluation protocol");
  add_eval_options(command, *options);
  command.on_run([options] {
    with_mpi(options->control.mpi, [&](Ranks& ranks) { run_eval(ranks, *options); });
  });
}

}  // namespace engram::apps
