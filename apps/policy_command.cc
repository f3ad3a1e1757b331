#include "apps/policy_command.h"

#include "apps/options.h"

namespace engram::apps {

void add_policy_command(const Command& command, const Option& own, PolicyCommand& policy) {
  const Option given =
      command
          .add_option(
              "--policy-command", policy.command,
              "An external policy: a command that implements the protocol of docs/evaluation.md")
          .type_name("COMMAND")
          .excludes(own);
  // Without the command one of engram's own policies would have that name.
  command.add_option("--policy-name", policy.name, "Its name in the results")
      .type_name("NAME")
      .default_str("external")
      .needs(given);
  add_int(command, "--policy-timeout", policy.timeout, 1, 86'400,
          "Seconds that it may take for an answer")
      .needs(given);
  command
      .add_flag("--tell-episodes", policy.tell_episodes,
                "Its requests have numbers and seeds of episodes, with which it can look up what "
                "they hide; results say so")
      .needs(given);
}

Document config_of(const PolicyCommand& policy) {
  return policy.given() ? Document(DocumentTable{{"command", policy.command}}) : Document();
}

void name_policy(const PolicyCommand& policy, Policy own, EvaluationSettings& settings) {
  if (!policy.given()) {
    settings.policy = name_of(own);
    return;
  }
  require_external_name("--policy-name", policy.name);
  settings.policy = policy.name.empty() ? "external" : policy.name;
  settings.policy_config = config_of(policy);
  settings.tell_episodes = policy.tell_episodes;
}

PolicyProcessOptions process_options(const PolicyCommand& policy, const BatchOptions& environment,
                                     int max_slots) {
  PolicyProcessOptions options;
  options.command = policy.command;
  options.timeout = std::chrono::seconds(policy.timeout);
  options.environment = environment;
  options.max_slots = max_slots;
  return options;
}

}  // namespace engram::apps
