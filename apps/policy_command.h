// External policies, given as commands.
#pragma once

#include <string>

#include "apps/command_line.h"
#include "apps/policy_server.h"
#include "protocol/eval/policies/policy_process.h"
#include "protocol/eval/run/settings.h"

namespace engram::apps {

struct PolicyCommand {
  std::string command;         // empty: none, one of engram's own policies acts
  std::string name;            // in results; empty: "external"
  int timeout = 300;           // seconds
  bool tell_episodes = false;  // with the seeds of their episodes
  PolicyServer server = {};    // in place of the command
  bool choices = false;        // the command names answers instead of sending actions
  int choices_stride = 1;      // control steps between the frames of its questions

  bool given() const { return !command.empty() || server.given(); }
};

// --policy-command, --policy-choices and --policy-server, which exclude `own` and each other, and
// what goes with them.
void add_policy_command(const Command& command, const Option& own, PolicyCommand& policy);

// Its description in results and settings; null if there is none.
Json config_of(const PolicyCommand& policy);

// Names the policy in the settings, and says what it does: the command, or else one of engram's own
// policies.
void name_policy(const PolicyCommand& policy, Policy own, EvaluationSettings& settings);

// For a process that plays up to max_slots environments of that kind.
PolicyProcessOptions process_options(const PolicyCommand& policy, const BatchOptions& environment,
                                     int max_slots);

}  // namespace engram::apps
