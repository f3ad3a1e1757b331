#include "apps/reproduce_command.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "apps/compare_command.h"
#include "apps/eval_options.h"
#include "apps/interruption.h"
#include "apps/output.h"
#include "core/base/names.h"
#include "protocol/eval/evaluation_run.h"
#include "protocol/eval/results/comparison.h"

namespace engram::apps {
namespace {

constexpr int kDefaultEpisodes = 5;

struct ReproduceOptions {
  std::string run;
  EvalOptions play;  // tasks, policy, num_envs, threads
  int episodes = kDefaultEpisodes;
  bool json = false;
};

[[noreturn]] void refuse(const std::string& what) { throw Error(Error::kInvalidArgument, what); }

bool has(const std::vector<std::string>& ids, const std::string& id) {
  return std::ranges::find(ids, id) != ids.end();
}

// What differs between episodes of a run and those that are played again.
enum class Cause { kNothing, kEnvironment, kPolicy, kEither };

constexpr std::array kCauseNames = {"same", "environment", "policy", "undecided"};
constexpr const auto& names_of(Cause) { return kCauseNames; }

// total: of the comparison. The first observations are the environment's alone, the first answers
// to equal ones the policy's. engram's own physics gives equal answers the same bits on every
// machine; MuJoCo's need not.
Cause cause_of(const Json& total, Physics physics) {
  const Json& same = part(total, "same_digests");
  if (is_null(same)) refuse("results without digests given; digests needed");
  const std::uint64_t pairs = whole_number(part(total, "pairs"));
  const auto all = [&](const char* key) { return whole_number(part(same, key)) == pairs; };
  if (!all("first_observations")) return Cause::kEnvironment;
  if (!all("first_answers")) return Cause::kPolicy;
  if (all("answers")) {
    const bool equal = all("observations") && whole_number(part(total, "only_a")) == 0 &&
                       whole_number(part(total, "only_b")) == 0;
    return equal ? Cause::kNothing : Cause::kEnvironment;
  }
  if (all("observations") || physics == Physics::kEngram) return Cause::kPolicy;
  return Cause::kEither;
}

std::string sentence_of(Cause cause, const std::optional<bool>& repeatable) {
  switch (cause) {
    case Cause::kNothing:
      return "neither environment nor policy differs";
    case Cause::kEnvironment:
      return "the environment differs (renderer, MuJoCo or machine); the policy cannot be judged";
    case Cause::kEither:
      return "environment or policy differ after the first answer; `engram compare` of two runs of "
             "--policy random tests the environment alone";
    case Cause::kPolicy:
      break;
  }
  return repeatable.value_or(true)
             ? "the policy differs: it answers the same here each time, and otherwise than in the "
               "run"
             : "the policy differs: it answers at random, in each of two plays here otherwise";
}

std::string to_plain_text(const Json& comparison) {
  Table rows({{"task"}, {"episodes", true}, {"success in the run", true}, {"again", true}});
  const auto rate = [](const Json& row, const char* key) {
    return fmt::format("{:.3f}", number(part(row, key)));
  };
  for (const Json& task : list(part(comparison, "tasks"))) {
    rows.add({text(part(task, "env_id")), std::to_string(whole_number(part(task, "pairs"))),
              rate(task, "sr_a"), rate(task, "sr_b")});
  }
  return rows.text() + alike_text(part(comparison, "total"));
}

// The first episodes of some tasks of the run, with its policy unless the command line has one.
EvaluationSettings settings_of_run(const ReproduceOptions& options, EvalOptions& play) {
  const std::optional<EvaluationSettings> run = settings_in(OpenFolder(options.run));
  if (!run)
    refuse(fmt::format("'{}' given, the folder of a run needed: it has no settings", options.run));
  if (!run->tells_seeds())
    refuse(fmt::format("'{}' is sealed, and its seeds are not known; open it first", options.run));
  EvaluationSettings settings = *run;
  settings.commitment.reset();
  settings.repeat = 1;
  settings.episodes = std::min(options.episodes, run->episodes);
  if (!play.ids.empty()) settings.tasks = play.ids;
  for (const std::string& id : settings.tasks) {
    if (has(run->tasks, id)) continue;
    refuse(fmt::format("{} given; '{}' has {}", id, options.run, fmt::join(run->tasks, ", ")));
  }
  require_policy_of("'" + options.run + "'", *run, play.policy);
  if (play.given.contains("policy")) settings.policy = name_of(play.protocol.policy);
  if (play.policy.given()) {
    play.policy.tell_episodes = run->tell_episodes;
    play.policy.choices_stride = run->choices_stride;
    play.policy.name = run->policy == "external" ? "" : run->policy;
    if (!is_null(run->policy_config)) complete_options(run->policy_config, play.policy.server);
    name_policy(play.policy, play.protocol.policy, settings);
  }
  return settings;
}

struct Replay {
  ResultSet results;
  Json identity;  // what the policy tells of itself
};

Replay played(const EvaluationSettings& settings, const EvalOptions& play) {
  EvaluationRun run(settings, std::nullopt);
  const Interruption interruption;
  Ranks alone;
  evaluate(alone, run.open_tasks(), protocol_of(play, settings, run.identity()),
           {.finished = [&run](const TaskResult& result) { run.add(result); },
            .tick = [&](const EvaluationStatus&) { interruption.check("nothing is written"); }},
           run.store());
  return {{.source = "episodes played again", .tasks = run.tasks()}, run.identity()->document()};
}

void reproduce(const ReproduceOptions& options) {
  EvalOptions play = options.play;
  const EvaluationSettings settings = settings_of_run(options, play);
  ResultSet run = read_results(options.run);
  std::erase_if(run.tasks,
                [&](const Json& task) { return !has(settings.tasks, text(part(task, "env_id"))); });
  const Replay again = played(settings, play);
  const Json told = PolicyIdentity::in(OpenFolder(options.run));
  const bool other = has_other_checkpoint(told, again.identity);
  const std::set<AllowedDifference> fewer = {AllowedDifference::kSeeds};
  Json comparison = compare_results(run, again.results, fewer);
  Cause cause = cause_of(part(comparison, "total"), settings.physics);
  std::optional<bool> repeatable;
  if (cause == Cause::kPolicy) {
    const Json twice = compare_results(again.results, played(settings, play).results, fewer);
    repeatable = cause_of(part(twice, "total"), settings.physics) == Cause::kNothing;
  }
  if (other && cause != Cause::kEnvironment) cause = Cause::kPolicy;
  if (options.json) {
    const JsonTable checkpoints = {{"run", checkpoint_of(told)},
                                   {"again", checkpoint_of(again.identity)}};
    print(to_text(JsonTable{{"verdict", name_of(cause)},
                            {"policy_repeats", repeatable ? Json(*repeatable) : Json()},
                            {"checkpoints", checkpoints},
                            {"comparison", std::move(comparison)}}));
  } else {
    std::string sentence = other && cause == Cause::kPolicy ? std::string("the policy differs")
                                                            : sentence_of(cause, repeatable);
    if (other) {
      sentence += fmt::format("; it tells checkpoint {} here, and told {} in the run",
                              checkpoint_text(again.identity), checkpoint_text(told));
    }
    print(to_plain_text(comparison) + sentence + "\n");
  }
  if (cause != Cause::kNothing) throw Error(Error::kUnavailable, "the run was not reproduced");
}

}  // namespace

void add_reproduce_command(const Command& program) {
  const auto options = std::make_shared<ReproduceOptions>();
  const Command command = program.add_command(
      "reproduce", "Plays some episodes of a run of `engram eval` again, and says what differs");
  command.add_option("RUN", options->run, "Its folder").required().type_name("FOLDER");
  command.add_option("ids", options->play.ids, "Tasks of it; default: all").type_name("ID");
  add_policy_options(command, options->play).default_str("the run's");
  command.when_parsed([command, options] {
    if (command.given("--policy")) options->play.given.insert("policy");
  });
  add_int(command, "--episodes", options->episodes, 1, std::numeric_limits<int>::max(),
          "Episodes per task, the first ones of the run");
  add_num_envs(command, options->play.protocol.num_envs)
      .description("Episodes that a thread runs together");
  add_threads(command, options->play.protocol.threads);
  add_json(command, options->json);
  command.footer(
      "Policy, observations, seeds, rules, renderer and physics are those of the run, and so are "
      "--replan, "
      "--history and what a server was asked with. A server or a command has to be given again: "
      "none is run because a file names it. Exit code 0 if nothing differs. The digests that "
      "decide are described in docs/evaluation.md.");
  command.on_run([options] { reproduce(*options); });
}

}  // namespace engram::apps
