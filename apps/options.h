// Options that several subcommands share. Bad values become an Error with the value given and the
// values allowed.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "apps/command_line.h"
#include "core/base/join.h"
#include "core/base/names.h"
#include "protocol/make/make.h"

namespace engram::apps {

// --- values ---

// A whole number of low..high, in decimal digits. `option` is named in the message.
std::uint64_t parse_unsigned(std::string_view option, const std::string& text, std::uint64_t low,
                             std::uint64_t high);
int parse_int(std::string_view option, const std::string& text, int low, int high);
// "target=2" or "positions=0.1,-0.2,..."
Pin parse_pin(const std::string& text);
// "touch_radius=0.02"
std::pair<std::string, Constant> parse_constant(const std::string& text);  // of --set
TaskOptionValue parse_option(const std::string& text);
PerturbationLevel parse_perturbation(const std::string& text);

Option add_int(const Command& command, const std::string& option, int& value, int low, int high,
               const std::string& help);
Option add_seed(const Command& command, std::uint64_t& seed, const std::string& help,
                const std::string& option = "--seed");

// --- names ---

// Values of --obs.
inline constexpr std::array kObsModes = {ObsMode::kState, ObsMode::kRgb, ObsMode::kObjects};
// Values of --obs of commands without a user's policy.
inline constexpr std::array kAllObsModes = {
    ObsMode::kState,           ObsMode::kRgb,
    ObsMode::kObjects,         ObsMode::kRgbDepth,
    ObsMode::kRgbSegmentation, ObsMode::kRgbDepthSegmentation,
    ObsMode::kRgbState,        ObsMode::kRgbObjects};

// Policies of a single task.
inline constexpr std::array kTaskPolicies = {Policy::kZero, Policy::kRandom, Policy::kOracle,
                                             Policy::kBlind, Policy::kSweep};

// Options whose value is one of some names; their help lists the names.
Option add_policy(const Command& command, Policy& policy, std::span<const Policy> allowed);
Option add_control_mode(const Command& command, std::optional<ControlMode>& mode);
// The value of that name, given to an option. Throws Error that lists the names.
template <class Enum>
Enum require_option(const char* option, const std::string& name) {
  if (const std::optional<Enum> found = find_named<Enum>(name)) return *found;
  throw Error(Error::kInvalidArgument, std::string(option) + ": '" + name + "' given, " +
                                           join(names_of(Enum())) + " allowed");
}

Option add_joint_proprio(const Command& command, bool& joint_proprio);
Option add_reward(const Command& command, RewardMode& mode);
Option add_auto_reset(const Command& command, AutoReset& mode);
Option add_rules(const Command& command, Rules& rules);
Option add_physics(const Command& command, Physics& physics);
Option add_split(const Command& command, std::optional<Split>& split);
// --obs of commands with a default of their own, which default_str describes.
Option add_obs_mode(const Command& command, std::optional<ObsMode>& mode,
                    std::span<const ObsMode> modes);
// --obs of descriptions: of an observation whose values are listed.
Option add_layout(const Command& command, ObsMode& mode);

// --- groups ---

Option add_num_envs(const Command& command, int& num_envs);
Option add_threads(const Command& command, int& threads);
Option add_lanes(const Command& command, int& lanes);
Option add_json(const Command& command, bool& json);

// --obs and --renderer.
void add_obs(const Command& command, MakeOptions& options, std::span<const ObsMode> modes);
void add_renderer(const Command& command, ImageSourceOptions& options);
// The renderer's name, or "none" without images.
std::string renderer_name(const BatchOptions& options);

// Further options of a batch: control mode, reward, pins, ... .
void add_env_options(const Command& command, MakeOptions& options);

// --pin NAME=VALUE, which may be given several times.
void add_pins(const Command& command, std::vector<Pin>& pins);

// --option NAME=VALUE, which may be given several times.
void add_constants(const Command& command, ConstantTable& constants);
void add_task_options(const Command& command, std::vector<TaskOptionValue>& choices,
                      const std::string& help);

// --perturb AXIS=LEVEL, likewise.
void add_perturbations(const Command& command, std::vector<PerturbationLevel>& levels);

// The library's defaults for a batch of that size.
MakeOptions batch_options(int num_envs, int threads);

// A selection of registered tasks.
struct TaskFilter {
  std::optional<Split> split;
  std::string family;  // empty: all
  bool canonical = false;

  bool any() const { return split.has_value() || !family.empty() || canonical; }
};

void add_filter(const Command& command, TaskFilter& filter);

// The tasks that pass, in the registry's order. Throws Error if there is no such family.
std::vector<const RegistryEntry*> select(const TaskFilter& filter);

}  // namespace engram::apps
