#include "apps/eval_options.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>

#include "apps/output.h"

namespace engram::apps {
namespace {

constexpr std::array kPolicies = {Policy::kOracle, Policy::kBlind, Policy::kZero, Policy::kRandom};

// Which options speak of which settings.
constexpr std::pair<const char*, const char*> kKeyOfOption[] = {
    {"ids", "tasks"},
    {"--split", "tasks"},
    {"--family", "tasks"},
    {"--canonical", "tasks"},
    {"--all", "tasks"},
    {"--episodes", "n_episodes"},
    {"--seed", "start_seed"},
    {"--obs", "obs_mode"},
    {"--renderer", "renderer"},
    {"--policy", "policy"},
    {"--policy-name", "policy"},
    {"--policy-command", "policy_config"},
    {"--option", "task_options"}};

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

}  // namespace

EvaluationSettings settings_of(const EvalOptions& options) {
  EvaluationSettings settings;
  std::vector<const RegistryEntry*> tasks = chosen_tasks(options);
  std::sort(tasks.begin(), tasks.end());  // as they lie in the registry
  for (const RegistryEntry* task : tasks) settings.tasks.emplace_back(task->id);
  const Protocol& protocol = options.protocol;
  settings.episodes = protocol.episodes;
  settings.start_seed = protocol.start_seed;
  EnvOptions environment = protocol.environment;
  if (options.policy_command.empty()) {
    settings.policy = policy_name(protocol.policy);
  } else {
    if (options.given.contains("policy") && options.policy_name.empty()) {
      throw Error(Error::kInvalidArgument,
                  "--policy and --policy-command given; one or the other allowed");
    }
    settings.policy = options.policy_name.empty() ? "external" : options.policy_name;
    settings.policy_config = {{"command", options.policy_command}};
    // Images are what the benchmark allows.
    if (!options.given.contains("obs_mode")) environment.obs_mode = ObsMode::kRgb;
  }
  settings.obs_mode = obs_name(environment);
  settings.renderer = renderer_name(environment);
  for (const OptionChoice& choice : environment.task_options) {
    settings.task_options[choice.name] = choice.value;
  }
  return settings;
}

EvaluationSettings resumed_settings(const EvalOptions& options, const ResultFolder& folder) {
  const std::optional<EvaluationSettings> before = folder.settings();
  if (!before) return settings_of(options);
  EvalOptions filled = options;
  if (!options.given.contains("tasks")) filled.ids = before->tasks;
  const Json now = settings_of(filled).document();
  const Json then = before->document();
  for (const std::string& key : options.given) {
    if (now[key] == then[key]) continue;
    throw Error(Error::kInvalidArgument,
                fmt::format("--resume: '{}' has results of {} {}; {} given now",
                            folder.path().string(), key, then[key].dump(), now[key].dump()));
  }
  return *before;
}

Protocol protocol_of(const EvalOptions& options, const EvaluationSettings& settings) {
  Protocol protocol = options.protocol;
  protocol.episodes = settings.episodes;
  protocol.start_seed = settings.start_seed;
  EnvOptions& environment = protocol.environment;
  environment.obs_mode = settings.obs_mode == "rgb" ? ObsMode::kRgb : ObsMode::kState;
  if (settings.renderer != "none") environment.image_options.renderer = settings.renderer;
  environment.task_options.clear();
  for (const auto& [name, value] : settings.task_options) {
    environment.task_options.push_back({name, value});
  }
  if (settings.policy_config.is_null()) {
    const auto own = std::find_if(kPolicies.begin(), kPolicies.end(), [&](Policy policy) {
      return settings.policy == policy_name(policy);
    });
    if (own == kPolicies.end()) {
      throw Error(Error::kInvalidArgument,
                  fmt::format("policy '{}' is not one of engram's own; --policy-command needed",
                              settings.policy));
    }
    protocol.policy = *own;
  }
  return protocol;
}

void add_eval_options(CLI::App& command, EvalOptions& options) {
  command.add_option("ids", options.ids, "Tasks, such as RememberColor9-VLA-v0")->type_name("ID");
  add_filter(command, options.filter);
  command.add_flag("--canonical", options.filter.canonical,
                   "The 90 tasks of the benchmark proper only");
  command.add_flag("--all", options.all, "All registered tasks that pass the filters");
  add_policy(command, options.protocol.policy, kPolicies);
  add_int(command, "--episodes", options.protocol.episodes, 1, std::numeric_limits<int>::max(),
          "Episodes per task");
  add_seed(command, options.protocol.start_seed, "Episode i has seed + i");
  add_num_envs(command, options.protocol.num_envs)
      ->description("Episodes that a thread plays together");
  add_obs(command, options.protocol.environment);
  const auto add_choices = [&options](const std::vector<std::string>& texts) {
    for (const std::string& text : texts) {
      options.protocol.environment.task_options.push_back(parse_option(text));
    }
  };
  command
      .add_option_function<std::vector<std::string>>(
          "--option", add_choices,
          "Chooses a variant of the tasks' rules, which all of them must have (repeatable)")
      ->type_name("NAME=VALUE")
      ->allow_extra_args(false);
  add_threads(command, options.protocol.threads);
  add_json(command, options.json);
  command
      .add_option("--out", options.out,
                  "Results go to DIR/<split>/<date_time>/: <ID>.json of every task as it finishes, "
                  "summary.json, report.html")
      ->type_name("DIR");
  command
      .add_option("--resume", options.resume,
                  "Goes on in the folder of an interrupted run, with its settings")
      ->type_name("DIR")
      ->excludes("--out");
  command.parse_complete_callback([&command, &options] {
    for (const auto& [option, key] : kKeyOfOption) {
      const CLI::Option* found = command.get_option_no_throw(option);
      if (found != nullptr && found->count() > 0) options.given.insert(key);
    }
  });
  command.footer(
      "One episode per seed, until it is terminated or as long as its horizon; success_once is the "
      "share of episodes with success in any step. Results do not depend on --num-envs, --threads "
      "or the number of processes under mpirun. docs/evaluation.md tells of policies from "
      "outside.");
}

}  // namespace engram::apps
