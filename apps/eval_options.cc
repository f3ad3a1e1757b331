#include "apps/eval_options.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>

#include "apps/run_flags.h"
#include "apps/task_choice.h"
#include "core/batch/scripted_policy.h"
#include "protocol/eval/run/choice_tasks.h"
#include "protocol/eval/run/suites.h"

namespace engram::apps {
namespace {

constexpr std::array kPolicies = {Policy::kOracle, Policy::kBlind, Policy::kSweep, Policy::kZero,
                                  Policy::kRandom};

// The setting of each option.
constexpr std::pair<const char*, const char*> kKeyOfOption[] = {
    {"ids", "tasks"},
    {"--split", "tasks"},
    {"--family", "tasks"},
    {"--canonical", "tasks"},
    {"--all", "tasks"},
    {"--suite", "tasks"},
    {"--policy", "policy"},
    {"--policy-name", "policy"},
    {"--policy-command", "policy_config"},
    {"--policy-command", "choices"},
    {"--policy-choices", "policy_config"},
    {"--policy-choices", "choices"},
    // begin generated: keys_of_flags (tools/surface, from api/surface.toml)
    {"--episodes", "n_episodes"},
    {"--obs", "obs_mode"},
    {"--seed", "start_seed"},
    {"--renderer", "renderer"},
    {"--option", "task_options"},
    {"--rules", "rules"},
    {"--set", "constants"},
    {"--tell-episodes", "tell_episodes"},
    {"--repeat", "repeat"},
    {"--policy-seed", "policy_seed"},
    {"--latency", "latency_steps"},
    {"--control-mode", "control_mode"},
    {"--joint-proprio", "joint_proprio"},
    {"--perturb", "perturbations"},
    {"--choices-stride", "choices_stride"},
    {"--physics", "physics"},
    // end generated
};

// Takes over the secret of a sealed run, which its folder does not have before the end.
void resume_commitment(const EvaluationSettings& now, const std::filesystem::path& folder,
                       EvaluationSettings& before) {
  const auto refuse = [&folder](const std::string& what) {
    throw Error(Error::kInvalidArgument,
                fmt::format("--resume: '{}' has results of {}", folder.string(), what));
  };
  if (now.commitment && !before.commitment)
    refuse("a run without --seed-file; --seed-file given now");
  if (now.commitment && now.commitment->hash() != before.commitment->hash()) {
    refuse(fmt::format("a secret with the SHA-256 {}; one with {} given now",
                       before.commitment->hash(), now.commitment->hash()));
  }
  if (!before.commitment || before.commitment->has_secret()) return;
  if (!now.commitment) refuse("a sealed run; its --seed-file needed");
  before.set_commitment(*now.commitment);
}

// The tasks of ids and filters, or of a suite, which may have its own number of episodes.
std::vector<std::string> chosen_ids(const EvalOptions& options, int& episodes) {
  if (options.suite.empty()) {
    return ids_in_order(chosen_tasks(options.ids, options.filter, options.all));
  }
  if (!options.ids.empty() || options.all || options.filter.any()) {
    throw Error(Error::kInvalidArgument,
                "--suite and task ids, --split, --family, --canonical or --all given; one or the "
                "other allowed");
  }
  const Suite& suite = require_suite("--suite", options.suite);
  if (!options.given.contains("n_episodes")) episodes = suite.episodes;
  std::vector<const RegistryEntry*> tasks;
  for (const std::string_view id : suite.ids) tasks.push_back(&require_entry(id));
  return ids_in_order(std::move(tasks));
}

}  // namespace

EvaluationSettings settings_of(const EvalOptions& options) {
  EvaluationSettings settings;
  const Protocol& protocol = options.protocol;
  static_cast<RunOptions&>(settings) = protocol;
  settings.tasks = chosen_ids(options, settings.episodes);
  check_rounds(settings.episodes, settings.repeat);
  if (!options.seed_file.empty()) {
    if (options.policy.tell_episodes) {
      throw Error(Error::kInvalidArgument,
                  "--seed-file, --tell-episodes: one of them allowed; a sealed run tells nobody "
                  "its seeds");
    }
    settings.set_commitment(SeedCommitment::read(options.seed_file));
  }
  MakeOptions environment = protocol.environment;
  name_policy(options.policy, protocol.policy, settings);
  // Images are what the benchmark allows.
  if (options.policy.given() && !options.given.contains("obs_mode")) {
    environment.obs_mode = ObsMode::kRgb;
  }
  settings.set_environment(environment);
  if (!options.policy.given()) require_mode_of(protocol.policy, settings.control_mode);
  if (settings.choices) require_choices(settings);
  for (const std::string& id : settings.tasks) (void)make_task(id, settings.constants);
  return settings;
}

EvaluationSettings resumed_settings(const EvalOptions& options,
                                    std::optional<EvaluationSettings> before,
                                    const std::filesystem::path& folder) {
  if (!before) return settings_of(options);
  EvalOptions filled = options;
  if (!options.given.contains("tasks")) filled.ids = before->tasks;
  const EvaluationSettings given_now = settings_of(filled);
  resume_commitment(given_now, folder, *before);
  const Json now = given_now.document();
  const Json then = before->document();
  for (const std::string& key : options.given) {
    const Json& given = part(now, key);
    const Json& used = part(then, key);
    if (given == used) continue;
    throw Error(Error::kInvalidArgument,
                fmt::format("--resume: '{}' has results of {} {}; {} given now", folder.string(),
                            key, to_line(used), to_line(given)));
  }
  require_policy_of("--resume: '" + folder.string() + "'", *before, options.policy);
  return *before;
}

// Commands of a folder are never run: its author may be another user.
void require_policy_of(const std::string& run, const EvaluationSettings& settings,
                       const PolicyCommand& policy) {
  if (is_null(settings.policy_config) || policy.given()) return;
  throw Error(Error::kInvalidArgument,
              fmt::format("{} has results of policy_config {}, and a command is not run because a "
                          "file names it; the same {} needed, or --policy-server",
                          run, to_line(settings.policy_config),
                          settings.choices ? "--policy-choices" : "--policy-command"));
}

Protocol protocol_of(const EvalOptions& options, const EvaluationSettings& settings,
                     const std::shared_ptr<PolicyIdentity>& identity) {
  Protocol protocol = engram::protocol_of(settings);
  protocol.num_envs = options.protocol.num_envs;
  protocol.threads = options.protocol.threads;
  if (is_null(settings.policy_config)) {
    const auto own = std::find_if(kPolicies.begin(), kPolicies.end(), [&](Policy policy) {
      return settings.policy == name_of(policy);
    });
    if (own == kPolicies.end()) {
      throw Error(Error::kInvalidArgument,
                  fmt::format("policy '{}' is not one of engram's own; --policy-command needed",
                              settings.policy));
    }
    protocol.policy = *own;
  } else {
    if (settings.policy_config != config_of(options.policy)) {
      throw Error(Error::kInvalidArgument,
                  fmt::format("policy '{}' is not the command that is given; only the program that "
                              "began the run can go on with it",
                              settings.policy));
    }
    PolicyProcessOptions process = process_options(options.policy, protocol.environment,
                                                   std::min(protocol.num_envs, protocol.episodes));
    if (identity) process.identified = [identity](const Json& told) { identity->take(told); };
    protocol.external = [process](const WorkContext& context) {
      return std::make_unique<PolicyProcess>(process, context);
    };
  }
  // Images cost time, little with images at hand; reports are written with files only.
  protocol.samples = !options.out.empty() || !options.resume.empty();
  return protocol;
}

Option add_policy_options(const Command& command, EvalOptions& options) {
  Option policy = add_policy(command, options.protocol.policy, kPolicies);
  add_policy_command(command, policy, options.policy);
  return policy;
}

void note_given_settings(const Command& command, EvalOptions& options) {
  command.when_parsed([command, &options] {
    for (const auto& [option, key] : kKeyOfOption) {
      if (command.given(option)) options.given.insert(key);
    }
  });
}

void add_task_choice(const Command& command, EvalOptions& options) {
  command.add_option("ids", options.ids, "Tasks, such as RememberColor9-VLA-v0").type_name("ID");
  add_filter(command, options.filter);
  command.add_flag("--canonical", options.filter.canonical,
                   "The 90 tasks of the benchmark proper only");
  command.add_flag("--all", options.all,
                   "All registered tasks that pass the filters, but RL tasks (--split rl)");
}

void add_environment(const Command& command, MakeOptions& environment) {
  add_obs(command, environment, kObsModes);
  add_control_mode(command, environment.control_mode);
  add_joint_proprio(command, environment.joint_proprio);
  add_rules(command, environment.rules);
  add_physics(command, environment.physics);
  add_constants(command, environment.constants);
  add_task_options(
      command, environment.task_options,
      "Chooses a variant of the tasks' rules, which all of them must have (repeatable)");
  add_perturbations(command, environment.perturbations);
}

void add_eval_options(const Command& command, EvalOptions& options) {
  add_task_choice(command, options);
  command
      .add_option("--suite", options.suite,
                  "The tasks of a named list, with its number of episodes unless --episodes is "
                  "given; mikasa5: five tasks x 100")
      .type_name(suite_names());
  add_policy_options(command, options);
  add_int(command, "--episodes", options.protocol.episodes, 1, std::numeric_limits<int>::max(),
          "Episodes per task");
  const Option seed = add_seed(command, options.protocol.start_seed, "Episode i has seed + i");
  const Option sealed =
      command
          .add_option(
              "--seed-file", options.seed_file,
              "Sealed run: seeds follow from the secret line in FILE (/dev/fd/N, -: an open "
              "descriptor); results have its hash, and the secret once all tasks are done")
          .type_name("FILE")
          .excludes(seed);
  command
      .add_flag("--keep-sealed", options.keep_sealed,
                "Does not write the secret at the end; --resume with the same --seed-file does")
      .needs(sealed);
  add_run_flags(command, "eval", options.protocol);
  add_num_envs(command, options.protocol.num_envs)
      .description("Episodes that a thread runs together");
  add_environment(command, options.protocol.environment);
  add_threads(command, options.protocol.threads);
  add_run_control(command, options.control);
  add_json(command, options.json);
  const Option out = command
                         .add_option("--out", options.out,
                                     "Results go to DIR/<split>/<date_time>/: every episode as it "
                                     "finishes, then <ID>.json of "
                                     "every task, summary.json, report.html")
                         .type_name("DIR");
  command
      .add_option(
          "--resume", options.resume,
          "Continues an interrupted run in its folder, with its settings: plays the episodes "
          "that are missing")
      .type_name("DIR")
      .excludes(out);
  note_given_settings(command, options);
  command.footer(
      "One episode per seed, until it is terminated or as long as its horizon; success_once is the "
      "share of episodes with success in any step. Results do not depend on --num-envs, --threads "
      "or the number of processes under mpirun. --replan 1,4 and --history last,8,2 play each "
      "pair. docs/evaluation.md describes external "
      "policies, which are one process per thread.");
}

}  // namespace engram::apps
