// Settings on which the results of an evaluation depend.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "protocol/eval/policies/seed_commitment.h"
#include "protocol/eval/run/evaluate.h"
#include "protocol/io/json.h"

namespace engram {

struct EvaluationSettings : RunOptions {
  std::vector<std::string> tasks;  // ids, in the registry's order
  ObsMode obs_mode = ObsMode::kRgb;
  std::string renderer = "none";  // of rgb observations
  ControlMode control_mode = ControlMode::kPdEeDeltaPose;
  std::map<std::string, double> task_options;
  // begin generated: environment (tools/surface, from api/surface.toml)
  // Rule set of the tasks.
  Rules rules = Rules::kReference;
  // Constants of all tasks.
  ConstantTable constants;
  // Proprio has the arm's seven joint angles and the gripper's opening, instead of the TCP's pose
  // and the opening.
  bool joint_proprio = false;
  // Departures from the tasks' usual scenes, robot and words.
  std::vector<PerturbationLevel> perturbations;
  // Engine that moves robot and props.
  Physics physics = Physics::kEngram;
  // end generated
  std::string policy;                        // "oracle", or the name of an external one
  Json policy_config;                        // further description in the results
  std::optional<SeedCommitment> commitment;  // of a sealed run, whose start_seed follows from it
  bool revealed = false;  // documents tell the seed and the secret of a sealed run

  // Commits the run to a secret; the seed is set if it is known.
  void set_commitment(SeedCommitment seed);
  // True if documents tell the seeds.
  bool tells_seeds() const { return !commitment || revealed; }

  // Takes over observations, renderer, control mode, rules, task options and constants. The tasks
  // have to be known: without a control mode, it is their own. Throws Error (kInvalidArgument) if
  // theirs differ.
  void set_environment(const MakeOptions& environment);

  Json document() const;
  // {sha256, secret} of a sealed run, null for others. The secret is null until it is opened.
  Json commitment_document() const;
  // Registers the variants that it is about. Throws Error: kIo if the document is not one of
  // settings, or one of another version; kInvalidArgument if tasks are defined in another way here.
  static EvaluationSettings of(const Json& document, const std::filesystem::path& file);
};

// Throws Error (kInvalidArgument) if results would take an external policy of that name for one of
// engram's own. `option`: what gave the name, for the message.
void require_custom_name(std::string_view option, std::string_view name);

// Throws Error (kInvalidArgument) if all rounds together are more episodes than an int can count.
void check_rounds(int episodes, int repeat);

// Control steps of a latency: "3", or "120ms" rounded up to whole steps. Throws Error
// (kInvalidArgument) for anything else, and for more than kMaxLatency. `option`: for the message.
int parse_latency(std::string_view option, const std::string& text);

// The ids of these tasks in the registry's order.
std::vector<std::string> ids_in_order(std::vector<const RegistryEntry*> tasks);

// The protocol with these settings: episodes, seeds and environments. Policy, threads and what else
// does not change the results are the caller's to set.
Protocol protocol_of(const EvaluationSettings& settings);

}  // namespace engram
