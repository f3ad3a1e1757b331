#include "apps/probe_command.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <limits>
#include <memory>
#include <optional>

#include "apps/eval_options.h"
#include "apps/interruption.h"
#include "apps/mpi_run.h"
#include "apps/output.h"
#include "apps/progress.h"
#include "apps/run_flags.h"
#include "apps/task_choice.h"
#include "protocol/eval/probe/probe_report.h"
#include "protocol/eval/probe/probe_run.h"
#include "protocol/io/folder_lock.h"
#include "protocol/make/definitions.h"
#include "protocol/parallel/shard_set.h"

namespace engram::apps {
namespace {

struct ProbeCommandOptions {
  EvalOptions eval;  // tasks, policy and episodes
  ProbeOptions probe;
};

// The rows of one probe's points; a task's twins are one point.
void add_points(const std::string& id, Probe probe, const Json& section, Table& table) {
  if (const Json* reason = find(section, "skipped")) {
    table.add({id, name_of(probe), "", "", "-", "-", text(*reason)});
    return;
  }
  if (probe == Probe::kTwins) {
    const Json& presents = part(section, "presents");
    table.add({id, name_of(probe), "pairs", fmt::format("{:.0f}", number(part(section, "pairs"))),
               "-", share_text(part(section, "follow")),
               fmt::format("wiped {}, swapped by past {}, stay {}; {:.0f} of {:.0f} presents equal",
                           share_text(part(section, "wiped_follow")),
                           share_text(part(part(section, "swapped"), "past")),
                           share_text(part(section, "stay")), number(part(presents, "equal")),
                           number(part(presents, "compared")))});
    return;
  }
  const char* const key = probe == Probe::kForgetting     ? "delay"
                          : probe == Probe::kInterference ? "others"
                                                          : "items";
  for (const Json& point : list(part(section, "points"))) {
    const std::string at = fmt::format("{:.0f}", number(part(point, key)));
    if (const Json* reason = find(point, "skipped")) {
      table.add({id, name_of(probe), key, at, "-", "-", text(*reason)});
      continue;
    }
    const Json* kind = find(point, "kind");
    const Json* oracle = find(point, "oracle");
    std::string note = kind != nullptr ? text(*kind) : std::string();
    if (oracle != nullptr) note = "oracle's success " + share_text(part(*oracle, "success"));
    table.add({id, name_of(probe), key, at, share_text(part(point, "success")),
               share_text(part(point, "first_answer")), note});
  }
}

std::string to_plain_text(const Json& document, const std::vector<Probe>& probes) {
  Table table({{"task"},
               {"probe"},
               {"over"},
               {"at", true},
               {"success", true},
               {"first answer", true},
               {"beside it"}});
  for (const Json& task : list(part(document, "tasks"))) {
    for (const Probe probe : probes) {
      add_points(text(part(task, "env_id")), probe, part(task, name_of(probe)), table);
    }
  }
  return table.text();
}

// Options of eval's policies that a script may still give; the help does not have them.
void refuse_options_of_eval(const PolicyCommand& policy) {
  if (policy.choices) {
    throw Error(Error::kInvalidArgument,
                "--policy-choices: given, --policy-command or --policy-server needed: probes are "
                "of policies that answer with actions");
  }
  if (policy.tell_episodes) {
    throw Error(Error::kInvalidArgument,
                "--tell-episodes: given, not allowed: trials of a probe share their seeds, and no "
                "policy is told which one it plays");
  }
}

std::vector<std::string> ids_of(const EvaluationSettings& settings, const ProbeOptions& probe) {
  std::vector<std::string> ids = settings.tasks;
  if (!probe.other.empty()) ids.push_back(probe.other);
  return ids;
}

// The folder of a run, kept from other runs, and the journal in it.
struct ProbeFolder {
  FolderLock lock;
  std::optional<RunHeader> before;  // of the journal that is there
  std::unique_ptr<Journal> journal = nullptr;

  const std::filesystem::path& path() const { return lock.folder().path(); }

  explicit ProbeFolder(const std::filesystem::path& folder) : lock(folder) {
    const auto content = read_journal(lock.folder());
    if (content) before = RunHeader::of(content->header, folder / kJournalFile);
  }
};

std::unique_ptr<ProbeFolder> folder_of_interrupted(const std::string& path) {
  auto folder = std::make_unique<ProbeFolder>(path);
  if (folder->before && folder->before->kind == kProbeKind) return folder;
  throw Error(Error::kInvalidArgument,
              fmt::format("--resume: '{}' has no unfinished probes", path));
}

// None without --out.
std::unique_ptr<ProbeFolder> make_folder(const EvalOptions& options) {
  if (options.out.empty()) return nullptr;
  std::filesystem::path folder = options.out;
  if (options.control.shard) folder /= shard_folder(*options.control.shard);
  require_writable_folder(folder);
  return std::make_unique<ProbeFolder>(folder);
}

std::string state_of(const ProbeFolder* folder, const EpisodePart& part) {
  if (folder == nullptr) return "no results were written";
  const std::string path = folder->path().string();
  return fmt::format(
      "finished episodes are in '{}'; {} goes on with the others", path,
      part.shard ? "the same command" : shell_line({"engram", "probe", "--resume", path}));
}

void run_coordinator(Ranks& ranks, const ProbeCommandOptions& options) {
  const EvalOptions& eval = options.eval;
  refuse_options_of_eval(eval.policy);
  require_folder(eval.control, eval.out);
  const bool resumed = !eval.resume.empty();
  std::unique_ptr<ProbeFolder> folder;
  ProbeOptions probe = options.probe;
  EpisodePart part{eval.control.shard, words_of_command()};
  std::optional<EvaluationSettings> before;
  if (resumed) {
    folder = folder_of_interrupted(eval.resume);
    part.shard = folder->before->shard;
    probe = probes_of(folder->before->run);
    before = EvaluationSettings::of(engram::part(folder->before->run, "settings"),
                                    folder->path() / kJournalFile);
  }
  const EvaluationSettings settings =
      resumed ? resumed_settings(eval, before, folder->path()) : settings_of(eval);
  ProbeRun run(settings, protocol_of(eval, settings), probe);
  if (!resumed) folder = make_folder(eval);
  const RunHeader header = run.header(part);
  if (folder) {
    folder->journal = std::make_unique<Journal>(folder->lock.folder(), header.document());
  }
  // The others wait until all is checked, so that mistakes are reported once.
  broadcast(ranks, JsonTable{{"run", header.run},
                             {"definitions", definitions_of(ids_of(settings, probe))}});
  Json document;
  {
    Progress view("probe", "steps");
    const Interruption interruption(Interruption::kGraceSeconds, eval.control.time_limit);
    const std::string state = state_of(folder.get(), part);
    const auto report = [&](int episodes, int all, std::uint64_t env_steps) {
      interruption.check(state);
      view.update(episodes / std::max(1.0, static_cast<double>(all)),
                  static_cast<double>(env_steps));
    };
    document = run.play(ranks, report,
                        {folder ? folder->journal.get() : nullptr, part.shard.value_or(Shard())});
  }
  if (part.shard) {
    return print_shard(*part.shard, folder->path(), folder->journal->size(), eval.json);
  }
  if (folder) {
    write_probes(document, folder->path());
    folder->journal->remove();
  }
  print_probes(document, probe.probes, eval.json);
}

void run_worker(Ranks& ranks, const ProbeCommandOptions& options) {
  const Json sent = broadcast(ranks, Json());
  const Json& run = part(sent, "run");
  const EvaluationSettings settings =
      EvaluationSettings::of(part(run, "settings"), "settings of rank 0");
  const ProbeOptions probe = probes_of(run);
  require_definitions(ids_of(settings, probe), part(sent, "definitions"), "rank 0");
  const Interruption interruption;  // rank 0 says what is saved, and ends all
  ProbeRun(settings, protocol_of(options.eval, settings), probe).play(ranks, {});
}

}  // namespace

ProbeOptions probes_of(const Json& run) {
  ProbeOptions probe;
  probe.probes.clear();
  for (const Json& name : list(part(run, "probes"))) {
    probe.probes.push_back(require_named<Probe>("probe", text(name)));
  }
  const Json& other = part(run, "other");
  if (!is_null(other)) probe.other = text(other);
  return probe;
}

void print_probes(const Json& document, const std::vector<Probe>& probes, bool json) {
  print(json ? to_text(document) : to_plain_text(document, probes));
}

void add_probe_command(const Command& program) {
  const auto options = std::make_shared<ProbeCommandOptions>();
  EvalOptions& eval = options->eval;
  // What a policy may see; the state would show it what is hidden.
  eval.protocol.environment.obs_mode = ObsMode::kObjects;
  const Command command = program.add_command(
      "probe", "Does a policy read its memory? Twins, forgetting, interference, capacity");
  add_task_choice(command, eval);
  command
      .add_option(
          "--probes",
          [options](const std::string& text) {
            options->probe.probes = parse_probes("--probes", text);
          },
          "Some of them, with commas; default: all")
      .type_name("twins,forgetting,interference,capacity");
  command
      .add_option("--other", options->probe.other,
                  "Interference: also episodes of this task between cue and question")
      .type_name("ID");
  add_policy_options(command, eval);
  for (const char* of_eval : {"--policy-choices", "--choices-stride", "--tell-episodes"}) {
    command.hide_option(of_eval);
  }
  add_int(command, "--episodes", eval.protocol.episodes, 1, std::numeric_limits<int>::max(),
          "Episodes at each point; pairs of twins");
  add_seed(command, eval.protocol.start_seed, "Episode i has seed + i");
  add_run_flags(command, "probe", eval.protocol);
  add_num_envs(command, eval.protocol.num_envs).description("Episodes that a thread runs together");
  add_environment(command, eval.protocol.environment);
  add_threads(command, eval.protocol.threads);
  add_run_control(command, eval.control);
  add_json(command, eval.json);
  const Option out =
      command
          .add_option("--out", eval.out,
                      "Writes probe.json and probe.html, a page with curves; every episode as it "
                      "finishes")
          .type_name("DIR");
  command
      .add_option("--resume", eval.resume,
                  "Continues interrupted probes in their folder, with their settings: plays the "
                  "episodes that are missing")
      .type_name("DIR")
      .excludes(out);
  note_given_settings(command, eval);
  command.footer(
      "Results do not depend on --num-envs, --threads or the number of processes under mpirun. "
      "docs/probe.md has the definitions, and says for which policies interference is fair.");
  command.on_run([options] {
    with_mpi(options->eval.control.mpi, [&](Ranks& ranks) {
      ranks.is_root() ? run_coordinator(ranks, *options) : run_worker(ranks, *options);
    });
  });
}

}  // namespace engram::apps
