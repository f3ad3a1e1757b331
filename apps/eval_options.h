// Options of `engram eval`.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "apps/command_line.h"
#include "apps/options.h"
#include "apps/policy_command.h"
#include "apps/run_control.h"
#include "protocol/eval/results/policy_identity.h"
#include "protocol/eval/results/result_files.h"
#include "protocol/eval/run/evaluate.h"

namespace engram::apps {

struct EvalOptions {
  std::vector<std::string> ids;
  TaskFilter filter;
  bool all = false;
  std::string suite;  // instead of them
  Protocol protocol;
  PolicyCommand policy;  // takes the place of the protocol's if it is given
  std::string out;
  std::string resume;
  RunControl control;
  std::string seed_file;
  bool keep_sealed = false;
  bool json = false;
  std::set<std::string> given;  // keys of the settings that the command line sets
};

// Ids, filters, --canonical and --all.
void add_task_choice(const Command& command, EvalOptions& options);
// --obs, and what else the environments of a policy are made with.
void add_environment(const Command& command, MakeOptions& environment);
// The policy, and all that goes with it. Returns the option of engram's own ones.
Option add_policy_options(const Command& command, EvalOptions& options);
// Sets `given` when the command line is read; after all options are added.
void note_given_settings(const Command& command, EvalOptions& options);

void add_eval_options(const Command& command, EvalOptions& options);

// The settings of the command line. Throws Error unless tasks are chosen in exactly one way.
EvaluationSettings settings_of(const EvalOptions& options);

// The settings of the run that is resumed in a folder; before: those it has, if it has any. Throws
// Error if the command line asks for others.
EvaluationSettings resumed_settings(const EvalOptions& options,
                                    std::optional<EvaluationSettings> before,
                                    const std::filesystem::path& folder);

// Throws Error if a run had an external policy, and no policy is given. run: for the message.
void require_policy_of(const std::string& run, const EvaluationSettings& settings,
                       const PolicyCommand& policy);

// The protocol with those settings. identity: takes what the policy tells of itself, if it is
// given.
Protocol protocol_of(const EvalOptions& options, const EvaluationSettings& settings,
                     const std::shared_ptr<PolicyIdentity>& identity = nullptr);

}  // namespace engram::apps
