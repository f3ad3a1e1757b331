#include "apps/policy_command.h"

#include "apps/options.h"

namespace engram::apps {
namespace {

// For the bridge to report that its server is late.
constexpr std::chrono::seconds kBridgeGrace{10};

}  // namespace

void add_policy_command(const Command& command, const Option& own, PolicyCommand& policy) {
  const Option given =
      command
          .add_option(
              "--policy-command", policy.command,
              "An external policy: a command that implements the protocol of docs/evaluation.md")
          .type_name("COMMAND")
          .excludes(own);
  // Without the command one of engram's own policies would have that name.
  const Option name = command.add_option("--policy-name", policy.name, "Its name in the results");
  name.type_name("NAME").default_str("external").needs(given);
  const Option timeout = add_int(command, "--policy-timeout", policy.timeout, 1, 86'400,
                                 "Seconds that it may take for an answer");
  timeout.needs(given);
  const Option tell =
      command.add_flag("--tell-episodes", policy.tell_episodes,
                       "Its requests have numbers and seeds of episodes, with which it can look up "
                       "what they hide; results say so");
  tell.needs(given);
  const auto take = [&policy](const std::string& option, const std::string& value) {
    policy.server.options.emplace_back(option, value);
  };
  const std::vector<Option> chunks = add_chunk_options(command, take);
  for (const Option& option : chunks) option.needs(given);
  const Option server = add_policy_server(command, [=, &policy](const std::string& url) {
    policy.server.url = url;
    for (const Option& option : {name, timeout, tell}) option.need_no_longer(given);
    for (const Option& option : chunks) option.need_no_longer(given);
  });
  server.excludes(own).excludes(given);
  const Option choices = command.add_option(
      "--policy-choices",
      [=, &policy](const std::string& text) {
        policy.command = text;
        policy.choices = true;
        for (const Option& option : {name, timeout, tell}) option.need_no_longer(given);
      },
      "An external policy that names an answer from a list instead of sending actions; a scripted "
      "hand carries it out (docs/choices.md)");
  choices.type_name("COMMAND").excludes(own).excludes(given).excludes(server);
  add_int(command, "--choices-stride", policy.choices_stride, 1, kMaxChoicesStride,
          "Control steps between the frames of its questions")
      .needs(choices);
  add_server_options(command, server, take);
}

Json config_of(const PolicyCommand& policy) {
  return policy.given() ? server_config(policy.server, policy.command) : Json();
}

void name_policy(const PolicyCommand& policy, Policy own, EvaluationSettings& settings) {
  if (!policy.given()) {
    settings.policy = name_of(own);
    return;
  }
  require_custom_name("--policy-name", policy.name);
  settings.policy = policy.name.empty() ? "external" : policy.name;
  settings.policy_config = config_of(policy);
  settings.tell_episodes = policy.tell_episodes;
  settings.choices = policy.choices;
  settings.choices_stride = policy.choices_stride;
}

PolicyProcessOptions process_options(const PolicyCommand& policy, const BatchOptions& environment,
                                     int max_slots) {
  PolicyProcessOptions options;
  options.command = policy.command;
  options.timeout = std::chrono::seconds(policy.timeout);
  if (policy.server.given() || !policy.server.options.empty()) {
    options.command = bridge_command(policy.server, policy.command, policy.timeout);
    options.server = policy.server.url;
    options.timeout += kBridgeGrace;
  }
  options.environment = environment;
  options.max_slots = max_slots;
  options.choices = policy.choices;
  return options;
}

}  // namespace engram::apps
