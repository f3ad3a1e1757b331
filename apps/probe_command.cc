#include "apps/probe_command.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <memory>

#include "apps/eval_options.h"
#include "apps/interruption.h"
#include "apps/mpi_run.h"
#include "apps/output.h"
#include "apps/progress.h"
#include "apps/run_flags.h"
#include "apps/task_choice.h"
#include "protocol/eval/probe/probe_report.h"
#include "protocol/eval/probe/probe_run.h"
#include "protocol/make/definitions.h"

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

std::string to_plain_text(const Json& document, const ProbeOptions& options) {
  Table table({{"task"},
               {"probe"},
               {"over"},
               {"at", true},
               {"success", true},
               {"first answer", true},
               {"beside it"}});
  for (const Json& task : list(part(document, "tasks"))) {
    for (const Probe probe : options.probes) {
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

void run_coordinator(Ranks& ranks, const ProbeCommandOptions& options) {
  refuse_options_of_eval(options.eval.policy);
  const EvaluationSettings settings = settings_of(options.eval);
  ProbeOptions probe = options.probe;
  probe.output = options.eval.out;
  ProbeRun run(settings, protocol_of(options.eval, settings), probe);
  // The others wait until all is checked, so that mistakes are reported once.
  broadcast(ranks, definitions_of(ids_of(settings, probe)));
  Json document;
  {
    Progress view("probe", "steps");
    const Interruption interruption;
    document = run.play(ranks, [&](int episodes, int all, std::uint64_t env_steps) {
      interruption.check("no results were written");
      view.update(episodes / std::max(1.0, static_cast<double>(all)),
                  static_cast<double>(env_steps));
    });
  }
  if (!options.eval.out.empty()) write_probes(document, options.eval.out);
  print(options.eval.json ? to_text(document) : to_plain_text(document, options.probe));
}

// The settings follow from the command line alone, which all ranks have; files of tasks may differ.
void run_worker(Ranks& ranks, const ProbeCommandOptions& options) {
  const Json definitions = broadcast(ranks, Json());
  const EvaluationSettings settings = settings_of(options.eval);
  require_definitions(ids_of(settings, options.probe), definitions, "rank 0");
  ProbeRun(settings, protocol_of(options.eval, settings), options.probe).play(ranks, {});
}

}  // namespace

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
  add_json(command, eval.json);
  command.add_option("--out", eval.out, "Writes probe.json and probe.html, a page with curves")
      .type_name("DIR");
  note_given_settings(command, eval);
  command.footer(
      "Results do not depend on --num-envs, --threads or the number of processes under mpirun. "
      "docs/probe.md has the definitions, and says for which policies interference is fair.");
  command.on_run([options] {
    with_mpi([&](Ranks& ranks) {
      ranks.is_root() ? run_coordinator(ranks, *options) : run_worker(ranks, *options);
    });
  });
}

}  // namespace engram::apps
