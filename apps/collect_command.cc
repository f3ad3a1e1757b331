#include "apps/collect_command.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <memory>
#include <numeric>
#include <optional>

#include "apps/collect_estimate.h"
#include "apps/interruption.h"
#include "apps/mpi_run.h"
#include "apps/options.h"
#include "apps/output.h"
#include "apps/progress.h"
#include "apps/python_module.h"
#include "apps/run_control.h"
#include "apps/task_choice.h"
#include "core/batch/scripted_policy.h"
#include "protocol/datasets/collection.h"
#include "protocol/datasets/collection_report.h"
#include "protocol/datasets/rl_collection.h"
#include "protocol/eval/run/settings.h"
#include "protocol/io/files.h"
#include "protocol/io/folder_lock.h"
#include "protocol/io/json.h"
#include "protocol/make/control_mode_choice.h"
#include "protocol/make/definitions.h"
#include "protocol/parallel/shard_set.h"

namespace engram::apps {
namespace {

namespace fs = std::filesystem;

constexpr const char* kReport = "collect_report.html";
constexpr std::string_view kNpz = "npz";
constexpr std::string_view kLerobot = "lerobot";
constexpr std::string_view kRl = "rl";
// Formats that Python writes.
constexpr std::string_view kConverted[] = {kLerobot, "rlds", "hdf5"};

// Options that are passed on to the streams that sets of these formats are made of.
constexpr const char* kPassedOn[] = {"--max-attempts", "--seed",    "--renderer",
                                     "--set",          "--rules",   "--num-envs",
                                     "--threads",      "--perturb", "--physics"};

struct CollectOptions {
  std::vector<std::string> ids;
  TaskFilter filter;
  bool all = false;
  ImageSourceOptions images;
  std::string out = ".";
  CollectionOptions collection{.plan = {}, .out = {}};
  bool estimate = false;
  bool stream = false;
  std::string format = "npz";
  std::vector<std::string> lerobot;  // its options, as words
  std::vector<std::string> passed;   // options that a stream has too, as words
  RunControl control;
  bool json = false;
};

JsonTable task_document(const DemonstrationFolder& folder) {
  return {{"env_id", folder.entry().id},   {"out", folder.path().string()},
          {"episodes", folder.episodes()}, {"steps", folder.steps()},
          {"attempts", folder.attempts()}, {"keep_rate", keep_rate(folder)}};
}

JsonTable task_document(const RlFolder& folder) {
  return {{"env_id", folder.entry().id},
          {"out", folder.path().string()},
          {"episodes", folder.episodes()},
          {"steps", folder.steps()},
          {"success_once", folder.success_once()}};
}

using Folders = std::vector<std::unique_ptr<DemonstrationFolder>>;

JsonTable document(const Folders& folders, const CollectionOptions& collection) {
  int episodes = 0;
  std::int64_t steps = 0;
  JsonList tasks;
  for (const auto& folder : folders) {
    episodes += folder->episodes();
    steps += folder->steps();
    tasks.emplace_back(task_document(*folder));
  }
  return {{"out", collection.out.string()},
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

std::string to_plain_text(const std::vector<std::unique_ptr<RlFolder>>& folders) {
  Table table(
      {{"task"}, {"episodes", true}, {"steps each", true}, {"success_once", true}, {"folder"}});
  for (const auto& folder : folders) {
    table.add({std::string(folder->entry().id), std::to_string(folder->episodes()),
               std::to_string(folder->horizon()), fmt::format("{:.3f}", folder->success_once()),
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
  const Interruption interruption(Interruption::kGraceSeconds, options.control.time_limit);
  const auto start = std::chrono::steady_clock::now();
  Folders folders = collect(ranks, tasks, options.collection, [&](const CollectionProgress& now) {
    if (!options.stream) {  // whose reader knows how far it is
      progress.update(static_cast<double>(now.episodes) / now.wanted,
                      static_cast<double>(now.env_steps));
    }
    timing.episodes = now.added;
    timing.env_steps = now.env_steps;
    interruption.check(
        options.stream
            ? "the stream is incomplete"
            : fmt::format("{} of {} episodes are in '{}'; the same command goes on with the others",
                          now.episodes, now.wanted, options.collection.out.string()));
  });
  timing.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return folders;
}

// In the layout of the benchmark's RL data.
void collect_rl_data(Ranks& ranks, const std::vector<const RegistryEntry*>& tasks,
                     const CollectOptions& options) {
  if (options.stream || options.estimate) {
    throw Error(Error::kInvalidArgument,
                "--format rl with --stream or --estimate; neither of them allowed");
  }
  const CollectionPlan& plan = options.collection.plan;
  if (plan.keep_failures || plan.max_attempts != CollectionPlan().max_attempts) {
    throw Error(Error::kInvalidArgument,
                "--format rl with --keep-failures or --max-attempts; neither of them allowed: it "
                "keeps every episode, of one attempt each");
  }
  Progress progress("collect", "steps");
  const Interruption interruption(Interruption::kGraceSeconds, options.control.time_limit);
  const auto folders =
      collect_rl(ranks, tasks, options.collection, [&](const CollectionProgress& now) {
        progress.update(static_cast<double>(now.episodes) / now.wanted,
                        static_cast<double>(now.env_steps));
        interruption.check(
            fmt::format("{} of {} episodes are in '{}'; the same command goes on with the others",
                        now.episodes, now.wanted, options.collection.out.string()));
      });
  if (!ranks.is_root()) return;
  if (!options.json) {
    print(to_plain_text(folders));
    return;
  }
  JsonList documents;
  int episodes = 0;
  std::int64_t steps = 0;
  for (const auto& folder : folders) {
    documents.emplace_back(task_document(*folder));
    episodes += folder->episodes();
    steps += folder->steps();
  }
  print(to_text(JsonTable{{"out", options.collection.out.string()},
                          {"format", kRl},
                          {"episodes", episodes},
                          {"steps", steps},
                          {"tasks", documents}}));
}

// A block of a stream: its length, 8 bytes, little-endian, and the bytes.
void print_block(std::span<const std::byte> bytes) {
  ByteWriter length;
  length.put(static_cast<std::uint64_t>(bytes.size()));
  print_bytes(length.bytes());
  print_bytes(bytes);
}

// A share of the attempts, into a folder of its own.
void collect_share(Ranks& ranks, const std::vector<const RegistryEntry*>& tasks,
                   const CollectOptions& options) {
  if (options.stream || options.estimate) {
    throw Error(Error::kInvalidArgument,
                "--shard with --stream or --estimate; neither of them allowed");
  }
  const Shard shard = *options.control.shard;
  const fs::path folder = options.collection.out / shard_folder(shard);
  const RunHeader header =
      shard_header(tasks, options.collection.plan, {shard, words_of_command()});
  std::optional<FolderLock> lock;
  std::optional<Journal> journal;
  if (ranks.is_root()) {
    require_writable_folder(folder);
    lock.emplace(folder);
    journal.emplace(lock->folder(), header.document());
  }
  {
    Progress progress("collect", "steps");
    const Interruption interruption(Interruption::kGraceSeconds, options.control.time_limit);
    const std::string state = fmt::format(
        "finished episodes are in '{}'; the same command goes on with the others", folder.string());
    collect_shard(ranks, tasks, options.collection, folder, header, journal ? &*journal : nullptr,
                  [&](const CollectionProgress& now) {
                    interruption.check(state);
                    progress.update(now.episodes / std::max(1.0, static_cast<double>(now.wanted)),
                                    static_cast<double>(now.env_steps));
                  });
  }
  if (ranks.is_root()) print_shard(shard, folder, journal->size(), options.json);
}

// Data files, an empty block, and metadata.json.
void stream(Ranks& ranks, std::span<const RegistryEntry* const> tasks, CollectOptions& options) {
  if (tasks.size() != 1 || options.json || !ranks.is_single()) {
    throw Error(
        Error::kInvalidArgument,
        "--stream with several tasks or processes, or --json; one task and one process needed");
  }
  options.collection.sink = print_block;
  CollectionTiming timing;
  const Folders folders = collect_all(ranks, {tasks.begin(), tasks.end()}, options, timing);
  print_block({});
  const std::string metadata = to_text(folders.front()->metadata());
  print_block(std::as_bytes(std::span(metadata)));
  require_complete(folders, options.collection.plan);
}

std::string this_program() { return std::filesystem::read_symlink("/proc/self/exe").string(); }

// The program of Python that collects into another format, by streams of this one.
[[noreturn]] void collect_converted(const std::vector<const RegistryEntry*>& tasks,
                                    const CollectOptions& options) {
  const std::string given = "--format " + options.format;
  if (options.stream || options.estimate) {
    throw Error(Error::kInvalidArgument,
                given + " with --stream or --estimate; one of them allowed");
  }
  // All data sets are written with the same actions.
  const ControlMode mode = common_control_mode(options.collection.plan.control_mode, tasks);
  require_mode_of(Policy::kOracle, mode);
  std::vector<std::string> words = python_words("engram.datasets", given);
  words.insert(words.end(), {"collect", "--format", options.format, "--command", this_program(),
                             "--out", options.out});
  words.insert(words.end(), options.lerobot.begin(), options.lerobot.end());
  const CollectionPlan& plan = options.collection.plan;
  words.push_back(fmt::format("--episodes={}", plan.episodes));
  words.push_back(fmt::format("--control-mode={}", name_of(mode)));
  if (plan.joint_proprio) words.emplace_back("--joint-proprio");
  if (plan.keep_failures) words.emplace_back("--keep-failures");
  if (plan.additions.labels) words.emplace_back("--labels");
  if (plan.additions.depth) words.emplace_back("--depth");
  if (plan.additions.segmentation) words.emplace_back("--segmentation");
  if (plan.additions.state) words.emplace_back("--state");
  if (plan.additions.objects) words.emplace_back("--objects");
  if (options.json) words.emplace_back("--json");
  for (const std::string& word : options.passed) words.push_back("--word=" + word);
  for (const RegistryEntry* task : tasks) words.emplace_back(task->id);
  // Keeps the memory of episodes, 98 KB a step, for the next ones: to have the kernel clear it anew
  // takes a third of a stream's time.
  ::setenv(
      "GLIBC_TUNABLES",
      "glibc.malloc.mmap_max=0:glibc.malloc.arena_max=1:glibc.malloc.trim_threshold=4294967296",
      /*overwrite=*/0);
  become(std::move(words), given);
}

void run(Ranks& ranks, CollectOptions& options) {
  const std::vector<const RegistryEntry*> tasks =
      chosen_tasks(options.ids, options.filter, options.all);
  if (!options.lerobot.empty() && options.format != kLerobot) {
    throw Error(Error::kInvalidArgument, "--format " + options.format + " with " +
                                             options.lerobot.front() +
                                             ", an option of lerobot; --format lerobot needed");
  }
  const bool rl = options.format == kRl;
  if (options.control.shard && options.format != kNpz) {
    throw Error(Error::kInvalidArgument, "--shard with --format " + options.format +
                                             "; npz, which `engram merge` makes one set of, and "
                                             "which can be converted then, allowed");
  }
  if (options.format != kNpz && !rl) collect_converted(tasks, options);
  if (!ranks.is_single()) {
    const std::vector<std::string> ids = ids_in_order(tasks);
    require_definitions(ids, broadcast(ranks, definitions_of(ids)), "rank 0");
  }
  options.collection.plan.renderer = options.images.renderer;
  options.collection.out = options.out;
  if (options.control.shard && !rl) return collect_share(ranks, tasks, options);
  if (rl) {
    collect_rl_data(ranks, tasks, options);
    return;
  }
  if (options.estimate) {
    if (!ranks.is_root()) return;
    const Interruption interruption;
    const CollectEstimate estimate = estimate_collection(tasks, options.collection, interruption);
    print(options.json ? to_text(estimate.document()) : estimate.text());
    return;
  }
  if (options.stream) {
    stream(ranks, tasks, options);
    return;
  }
  CollectionTiming timing;
  if (ranks.is_root()) {
    MakeOptions env;
    env.rules = options.collection.plan.rules;
    env.constants = options.collection.plan.constants;
    warn_of_constants(tasks, env);
  }
  const Folders folders = collect_all(ranks, tasks, options, timing);
  if (!ranks.is_root()) return;
  report_collection(folders, options.collection, timing, options.json);
}

}  // namespace

void report_collection(const std::vector<std::unique_ptr<DemonstrationFolder>>& folders,
                       const CollectionOptions& collection, const CollectionTiming& timing,
                       bool json) {
  write_output(collection.out / kReport, collection_report(folders, timing));
  print(json ? to_text(document(folders, collection)) : to_plain_text(folders));
  require_complete(folders, collection.plan);
}

namespace {

void add_format(const Command& command, CollectOptions& options) {
  const auto take = [&options](const std::string& name) {
    const bool known =
        name == kNpz || name == kRl || std::ranges::find(kConverted, name) != std::end(kConverted);
    if (!known) {
      throw Error(Error::kInvalidArgument,
                  "--format: '" + name + "' given, npz, lerobot, rlds, hdf5 or rl allowed");
    }
    options.format = name;
  };
  const Option format =
      command
          .add_option(
              "--format", take,
              "Of data sets: DIR/data_<format>/<ID>, with no NPZ between. Others than npz and rl "
              "need Python, and leave tasks alone that are there already. rl: "
              "DIR/MIKASA-Robo/unbatched/<ID>, the layout of the benchmark's RL data: whole "
              "episodes of the oracle, failed ones too, 1000 of each task unless --episodes is "
              "given")
          .type_name("npz|lerobot|rlds|hdf5|rl")
          .default_str("npz");
  const auto add = [&](const char* name, const char* word, const char* type, const char* help) {
    const auto pass_on = [&options, word](const std::string& value) {
      options.lerobot.push_back(fmt::format("{}={}", word, value));
    };
    command.add_option(name, pass_on, help).type_name(type).needs(format);
  };
  add("--frames", "--frames", "videos|images|auto", "Of lerobot; default: videos");
  add("--codec", "--codec", "ENCODER",
      "Of lerobot's videos, an encoder of FFmpeg; default: libx264");
  add("--lerobot-version", "--version", "3.0|2.1", "Default: 3.0");
}

}  // namespace

void add_collect_command(const Command& program,
                         const std::shared_ptr<const std::vector<std::string>>& task_options) {
  const auto options = std::make_shared<CollectOptions>();
  const Command command = program.add_command(
      "collect", "Demonstrations of the oracle, as NPZ files or in other formats");
  command.add_option("ids", options->ids, "Tasks, such as RememberColor9-VLA-v0").type_name("ID");
  add_filter(command, options->filter);
  command.add_flag("--canonical", options->filter.canonical, "Tasks of the benchmark proper only");
  command.add_flag("--all", options->all,
                   "All registered tasks that pass the filters, but RL tasks (--split rl)");
  CollectionPlan& plan = options->collection.plan;
  add_int(command, "--episodes", plan.episodes, 1, std::numeric_limits<int>::max(),
          "Episodes per task");
  add_int(command, "--max-attempts", plan.max_attempts, 1, 100'000'000,
          "Attempts per task, of one episode or one batch");
  add_seed(command, plan.start_seed, "The first episode's; those after it follow one by one");
  add_renderer(command, options->images);
  command.add_flag(
      "--labels", plan.additions.labels,
      "Also subtasks, plan and memory in words, keyframes, progress, and where cameras "
      "see the object that is meant: privileged");
  command.add_flag("--depth", plan.additions.depth, "Also both cameras' depth images, in mm");
  command.add_flag("--segmentation", plan.additions.segmentation,
                   "Also both cameras' images of which thing is where");
  const Option state = command.add_flag(
      "--state", plan.additions.state,
      "Also the row of the observation mode state: privileged, for critics and teachers");
  command
      .add_flag("--objects", plan.additions.objects, "Also the row of the observation mode objects")
      .excludes(state);
  add_constants(command, plan.constants);
  add_rules(command, plan.rules);
  add_physics(command, plan.physics);
  add_perturbations(command, plan.perturbations);
  add_control_mode(command, plan.control_mode);
  add_joint_proprio(command, plan.joint_proprio);
  command.add_flag("--keep-failures", plan.keep_failures,
                   "Keeps episodes that fail as well, every episode for itself");
  add_num_envs(command, options->collection.num_envs);
  add_threads(command, options->collection.threads);
  add_run_control(command, options->control);
  command.add_option("--out", options->out, "Folder to hold data_<format>/<ID>")
      .type_name("DIR")
      .default_str(options->out);
  command.add_flag(
      "--estimate", options->estimate,
      "Plays the first attempts of each task only, says how large the files will be and "
      "how long they take, and writes nothing");
  command.add_flag("--stream", options->stream,
                   "Writes the data files of one task to standard output, not compressed, for "
                   "programs that convert them (docs/datasets.md), and nothing into --out");
  add_format(command, *options);
  add_json(command, options->json);
  command.footer(
      "Keeps episodes that succeed, up to their first success; --format rl whole ones, all of "
      "them. "
      "After an interruption, the same command continues. Files do not depend on --num-envs, "
      "--threads or the number of processes.");
  command.when_parsed([command, options] {
    const bool unset = command.values("--episodes").empty();
    if (options->format == kRl && unset) options->collection.plan.episodes = kRlEpisodes;
    for (const char* name : kPassedOn) {
      for (const std::string& value : command.values(name)) {
        options->passed.push_back(fmt::format("{}={}", name, value));
      }
    }
  });
  command.on_run([options, task_options] {
    // Taken after this command's own options.
    options->passed.insert(options->passed.begin(), task_options->begin(), task_options->end());
    with_mpi(options->control.mpi, [&](Ranks& ranks) { run(ranks, *options); });
  });
}

}  // namespace engram::apps
