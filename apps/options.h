// Options that several subcommands share. Bad values become an Error that says what was given and
// what is allowed.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "protocol/batch/make.h"

namespace engram::apps {

// --- values ---

// A whole number of low..high, in decimal digits. `option` is named in the message.
std::uint64_t parse_unsigned(std::string_view option, const std::string& text, std::uint64_t low,
                             std::uint64_t high);
int parse_int(std::string_view option, const std::string& text, int low, int high);
// "target=2" or "positions=0.1,-0.2,..."
Pin parse_pin(const std::string& text);
// "touch_radius=0.02"
OptionChoice parse_option(const std::string& text);

CLI::Option* add_int(CLI::App& app, const std::string& option, int& value, int low, int high,
                     const std::string& help);
CLI::Option* add_seed(CLI::App& app, std::uint64_t& seed, const std::string& help);

// --- names ---

const char* policy_name(Policy policy);

// Options whose value is one of some names; their help lists the names.
CLI::Option* add_policy(CLI::App& app, Policy& policy, std::span<const Policy> allowed);
CLI::Option* add_control_mode(CLI::App& app, ControlMode& mode);
CLI::Option* add_reward(CLI::App& app, RewardMode& mode);
CLI::Option* add_auto_reset(CLI::App& app, AutoReset& mode);
CLI::Option* add_split(CLI::App& app, std::optional<Split>& split);
// --obs, where both observations are meant unless one is named.
CLI::Option* add_obs_mode(CLI::App& app, std::optional<ObsMode>& mode);

// --- groups ---

inline constexpr int kMaxEnvs = 1'000'000;
inline constexpr int kMaxThreads = 1024;

CLI::Option* add_num_envs(CLI::App& app, int& num_envs);
CLI::Option* add_threads(CLI::App& app, int& threads);
CLI::Option* add_json(CLI::App& app, bool& json);

// --obs and --renderer: what is observed, and who draws it.
void add_obs(CLI::App& app, EnvOptions& options);
void add_renderer(CLI::App& app, ImageSourceOptions& options);
// "state" or "rgb", and the renderer's name or "none".
const char* obs_name(ObsMode mode);
const char* obs_name(const EnvOptions& options);
std::string renderer_name(const EnvOptions& options);

// What else a batch of environments can be given: control mode, reward, pins, ... .
void add_env_options(CLI::App& app, EnvOptions& options);

// The library's defaults for a batch of that size.
EnvOptions batch_options(int num_envs, int threads);

// Which registered tasks are meant.
struct TaskFilter {
  std::optional<Split> split;
  std::string family;  // empty: all
  bool canonical = false;

  bool any() const { return split.has_value() || !family.empty() || canonical; }
};

void add_filter(CLI::App& app, TaskFilter& filter);

// The tasks that pass, in the registry's order. Throws Error if there is no such family.
std::vector<const RegistryEntry*> select(const TaskFilter& filter);

}  // namespace engram::apps
