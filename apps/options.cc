#include "apps/options.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>

#include "protocol/eval/run/settings.h"
#include "protocol/io/json.h"

namespace engram::apps {
namespace {

[[noreturn]] void refuse(std::string_view option, std::string_view given,
                         std::string_view allowed) {
  throw Error(Error::kInvalidArgument,
              fmt::format("{}: '{}' given, {} allowed", option, given, allowed));
}

template <class T>
struct Choice {
  std::string_view name;
  T value;
};

template <class T>
std::string names_of(std::span<const Choice<T>> choices, std::string_view between = "|") {
  std::string names;
  for (const auto& choice : choices) {
    if (!names.empty()) names += between;
    names += choice.name;
  }
  return names;
}

template <class T>
std::vector<Choice<T>> named(std::span<const T> values) {
  std::vector<Choice<T>> choices;
  for (const T value : values) choices.push_back({name_of(value), value});
  return choices;
}

// Sets `value` to the choice that the user names; the help shows the names and the default.
template <class T, class Target>
Option add_choice(const Command& command, const std::string& option, Target& value,
                  std::vector<Choice<T>> choices, const std::string& help,
                  std::string_view between = "|") {
  const std::string names = names_of<T>(choices);
  const std::string allowed = names_of<T>(choices, between);
  const auto assign = [&value, choices, option, allowed](const std::string& text) {
    const auto found =
        std::find_if(choices.begin(), choices.end(),
                     [&text](const Choice<T>& choice) { return choice.name == text; });
    if (found == choices.end()) refuse(option, text, allowed);
    value = found->value;
  };
  const Option added = command.add_option(option, assign, help);
  added.type_name(names);
  for (const auto& choice : choices) {
    if (value == choice.value) added.default_str(std::string(choice.name));
  }
  return added;
}

// Digits with an optional plus sign, as a number; nullopt if the text is anything else.
template <class T>
std::optional<T> parse_number(std::string_view text) {
  if (text.starts_with('+') && !text.starts_with("+-")) text.remove_prefix(1);
  T value{};
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc() || stop != end) return std::nullopt;
  return value;
}

// An option without a value, which sets the field.
template <class Field>
void add_switch(const Command& command, const char* option, Field& field, bool sets,
                const char* help) {
  command.add_flag(
      option, [&field, sets] { field = sets; }, help);
}

constexpr std::string_view kConstantForm =
    "NAME=VALUE, NAME=VALUE,VALUE,... or NAME=JSON, a list or an object,";
constexpr std::string_view kPinForm = "NAME=NUMBER or NAME=NUMBER,NUMBER,...";
constexpr std::string_view kOptionForm = "NAME=NUMBER";
constexpr std::string_view kPerturbationForm = "AXIS=LEVEL, from 0 to 1";

// NAME=VALUE,VALUE,...; at least one value, which may be empty.
struct Setting {
  std::string name;
  std::string_view text;                 // all values, of the text
  std::vector<std::string_view> values;  // of the text
};

Setting split_setting(std::string_view option, const std::string& text, std::string_view form) {
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos || equals == 0) refuse(option, text, form);
  std::string_view rest = std::string_view(text).substr(equals + 1);
  Setting setting{text.substr(0, equals), rest, {}};
  while (true) {
    const std::size_t comma = rest.find(',');
    setting.values.push_back(rest.substr(0, comma));
    if (comma == std::string_view::npos) return setting;
    rest.remove_prefix(comma + 1);
  }
}

}  // namespace

// --- values ---

std::uint64_t parse_unsigned(std::string_view option, const std::string& text, std::uint64_t low,
                             std::uint64_t high) {
  const auto value = parse_number<std::uint64_t>(text);
  if (!value || *value < low || *value > high) {
    refuse(option, text, fmt::format("a whole number of {} to {}", low, high));
  }
  return *value;
}

int parse_int(std::string_view option, const std::string& text, int low, int high) {
  const auto value = parse_number<int>(text);
  if (!value || *value < low || *value > high) {
    refuse(option, text, fmt::format("a whole number of {} to {}", low, high));
  }
  return *value;
}

Pin parse_pin(const std::string& text) {
  Setting setting = split_setting("--pin", text, kPinForm);
  Pin pin{std::move(setting.name), {}};
  for (const std::string_view part : setting.values) {
    const auto value = parse_number<double>(part);
    if (!value || !std::isfinite(*value)) refuse("--pin", text, kPinForm);
    pin.values.push_back(*value);
  }
  return pin;
}

TaskOptionValue parse_option(const std::string& text) {
  Setting setting = split_setting("--option", text, kOptionForm);
  const auto value = parse_number<double>(setting.values.front());
  if (setting.values.size() != 1 || !value || !std::isfinite(*value)) {
    refuse("--option", text, kOptionForm);
  }
  return {std::move(setting.name), *value};
}

PerturbationLevel parse_perturbation(const std::string& text) {
  const Setting setting = split_setting("--perturb", text, kPerturbationForm);
  const auto level = parse_number<double>(setting.values.front());
  if (setting.values.size() != 1 || !level || !(*level >= 0 && *level <= 1)) {
    refuse("--perturb", text, kPerturbationForm);
  }
  return {require_axis(setting.name), *level};
}

std::pair<std::string, Constant> parse_constant(const std::string& text) {
  Setting setting = split_setting("--set", text, kConstantForm);
  if (setting.text.starts_with('[') || setting.text.starts_with('{')) {
    std::optional<Json> value = parse_json(setting.text);
    if (!value) refuse("--set", text, kConstantForm);
    return {std::move(setting.name), std::move(*value)};
  }
  ConstantList values;
  for (const std::string_view part : setting.values) {
    if (part.empty()) refuse("--set", text, kConstantForm);
    const auto whole = parse_number<std::int64_t>(part);
    const auto real = parse_number<double>(part);
    if (whole) {
      values.emplace_back(*whole);
    } else if (real && std::isfinite(*real)) {
      values.emplace_back(*real);
    } else {
      values.emplace_back(part);
    }
  }
  Constant value = values.size() == 1 ? values.front() : Constant(std::move(values));
  return {std::move(setting.name), std::move(value)};
}

Option add_int(const Command& command, const std::string& option, int& value, int low, int high,
               const std::string& help) {
  const auto assign = [&value, option, low, high](const std::string& text) {
    value = parse_int(option, text, low, high);
  };
  return command.add_option(option, assign, help).type_name("N").default_str(std::to_string(value));
}

Option add_seed(const Command& command, std::uint64_t& seed, const std::string& help,
                const std::string& option) {
  const auto assign = [&seed, option](const std::string& text) {
    seed = parse_unsigned(option, text, 0, std::numeric_limits<std::uint64_t>::max());
  };
  return command.add_option(option, assign, help).type_name("N").default_str(std::to_string(seed));
}

// --- names ---

Option add_policy(const Command& command, Policy& policy, std::span<const Policy> allowed) {
  return add_choice(command, "--policy", policy, named<Policy>(allowed),
                    "Policy that chooses the actions");
}

Option add_control_mode(const Command& command, std::optional<ControlMode>& mode) {
  std::vector<ControlMode> all;
  all.reserve(kControlModes);
  for (int i = 0; i < kControlModes; ++i) all.push_back(static_cast<ControlMode>(i));
  return add_choice(command, "--control-mode", mode, named<ControlMode>(all),
                    "Meaning of actions (oracle, blind and sweep: pd_ee_delta_pose, pd_joint_pos, "
                    "pd_joint_delta_pos); default: the task's own")
      .type_name("MODE");
}

Option add_joint_proprio(const Command& command, bool& joint_proprio) {
  return command.add_flag(
      "--joint-proprio", joint_proprio,
      "Proprio: the arm's seven joint angles and the gripper's opening, instead of "
      "the TCP's pose and the opening");
}

Option add_reward(const Command& command, RewardMode& mode) {
  static constexpr std::array kModes = {RewardMode::kSparse, RewardMode::kDense,
                                        RewardMode::kNormalizedDense};
  return add_choice(command, "--reward", mode, named<RewardMode>(kModes), "Reward");
}

Option add_auto_reset(const Command& command, AutoReset& mode) {
  static constexpr std::array kModes = {AutoReset::kNextStep, AutoReset::kSameStep,
                                        AutoReset::kOff};
  return add_choice(command, "--auto-reset", mode, named<AutoReset>(kModes),
                    "Reset of environments whose episode has ended");
}

Option add_rules(const Command& command, Rules& rules) {
  static constexpr std::array kBoth = {Rules::kReference, Rules::kOriginal};
  return add_choice(
      command, "--rules", rules, named<Rules>(kBoth),
      "Rule set of the tasks: the defaults of their options, which --option overrides");
}

Option add_physics(const Command& command, Physics& physics) {
  static constexpr std::array kBoth = {Physics::kEngram, Physics::kMujoco};
  return add_choice(command, "--physics", physics, named<Physics>(kBoth),
                    "Engine that moves robot and props: engram's own, or MuJoCo's step");
}

Option add_split(const Command& command, std::optional<Split>& split) {
  std::vector<Choice<Split>> choices;
  for (const Split value :
       {Split::kShort, Split::kMedium, Split::kLong, Split::kExtended, Split::kRl}) {
    choices.push_back({split_name(value), value});
  }
  return add_choice(command, "--split", split, std::move(choices), "Tasks of this split only");
}

Option add_obs_mode(const Command& command, std::optional<ObsMode>& mode,
                    std::span<const ObsMode> modes) {
  return add_choice(command, "--obs", mode, named<ObsMode>(modes), "This observation only");
}

Option add_layout(const Command& command, ObsMode& mode) {
  static constexpr std::array kListed = {ObsMode::kState, ObsMode::kObjects,
                                         ObsMode::kRgbSegmentation};
  return add_choice(command, "--obs", mode, named<ObsMode>(kListed),
                    "Observation whose values are listed", " or ");
}

// --- groups ---

Option add_num_envs(const Command& command, int& num_envs) {
  return add_int(command, "--num-envs", num_envs, 1, kMaxNumEnvs, "Environments stepped together");
}

Option add_threads(const Command& command, int& threads) {
  return add_int(command, "--threads", threads, 0, kMaxThreads, "Threads; 0: one per core");
}

Option add_lanes(const Command& command, int& lanes) {
  return add_int(command, "--lanes", lanes, 0, 16,
                 "Robots side by side in vector registers: 1, 4, 8 or 16; 0: as many as fit");
}

Option add_json(const Command& command, bool& json) {
  return command.add_flag("--json", json,
                          "One JSON document on standard output, nothing else there");
}

void add_obs(const Command& command, MakeOptions& options, std::span<const ObsMode> modes) {
  add_choice(command, "--obs", options.obs_mode, named<ObsMode>(modes),
             "Observation; rgb: base and wrist camera, 128 x 128; objects: the "
             "visible objects as numbers",
             " or ");
  add_renderer(command, options.image_options);
}

void add_renderer(const Command& command, ImageSourceOptions& options) {
  const auto take = [&options](const std::string& text) {
    if (text != "cpu" && text != "egl") refuse("--renderer", text, "cpu or egl");
    options.renderer = text;
  };
  command.add_option("--renderer", take, "Renderer of images")
      .type_name("cpu|egl")
      .default_str("cpu");
}

std::string renderer_name(const BatchOptions& options) {
  return observes_images(options.obs_mode) ? options.image_options.renderer : "none";
}

void add_env_options(const Command& command, MakeOptions& options) {
  add_control_mode(command, options.control_mode);
  add_joint_proprio(command, options.joint_proprio);
  add_reward(command, options.reward_mode);
  add_auto_reset(command, options.auto_reset);
  add_int(
      command, "--max-episode-steps", options.max_episode_steps, 0, kMaxMaxEpisodeSteps,
      "Control steps after which episodes are truncated, even before success is possible; 0: the "
      "task's horizon");
  add_pins(command, options.pins);
  add_constants(command, options.constants);
  add_rules(command, options.rules);
  add_physics(command, options.physics);
  add_task_options(
      command, options.task_options,
      "Chooses a variant of the task's rules (repeatable; `engram info ID` lists them)");
  add_perturbations(command, options.perturbations);
  const auto set_rotation_sign = [&options](const std::string& text) {
    options.rotation_sign = parse_int("--rotation-sign", text, -1, 1);
    if (options.rotation_sign == 0) refuse("--rotation-sign", text, "-1 or 1");
  };
  command
      .add_option("--rotation-sign", set_rotation_sign,
                  "-1: rotations with upstream's sign; 1: with the action's sign")
      .type_name("SIGN")
      .default_str(std::to_string(options.rotation_sign));
  // begin generated: switches (tools/surface, from api/surface.toml)
  add_switch(command, "--no-sleep", options.sleep, false,
             "Every shortcut of the physics off: slower, for comparison");
  add_switch(command, "--no-freeze-cue", options.freeze_cue, false,
             "Actions count during cue and empty phase too");
  add_switch(command, "--terminate-on-success", options.terminate_on_success, true,
             "Episodes end at success, whatever the task's rule");
  add_switch(command, "--no-terminate-on-success", options.terminate_on_success, false,
             "Episodes go on after success, whatever the task's rule");
  add_switch(command, "--no-terminate-on-failure", options.terminate_on_failure, false,
             "Episodes do not end at failure");
  // end generated
}

void add_pins(const Command& command, std::vector<Pin>& pins) {
  const auto take = [&pins](const std::string& text) { pins.push_back(parse_pin(text)); };
  command
      .add_repeatable("--pin", take,
                      "Fixes a random quantity of every episode, such as target=2 (repeatable; "
                      "`engram info ID` lists them)")
      .type_name("NAME=VALUE");
}

void add_task_options(const Command& command, std::vector<TaskOptionValue>& choices,
                      const std::string& help) {
  const auto take = [&choices](const std::string& text) { choices.push_back(parse_option(text)); };
  command.add_repeatable("--option", take, help).type_name("NAME=VALUE");
}

void add_perturbations(const Command& command, std::vector<PerturbationLevel>& levels) {
  const auto take = [&levels](const std::string& text) {
    levels.push_back(parse_perturbation(text));
    check_perturbations(levels);
  };
  command
      .add_repeatable("--perturb", take,
                      "How far episodes depart from the usual scene, 0 to 1, along " +
                          join(kPerturbationAxisNames) + " (repeatable; docs/variants.md)")
      .type_name("AXIS=LEVEL");
}

void add_constants(const Command& command, ConstantTable& constants) {
  const auto take = [&constants](const std::string& text) {
    constants.push_back(parse_constant(text));
  };
  command
      .add_repeatable(
          "--set", take,
          "Changes a constant of the task: COLORS=7, CUE_PHASE_STEPS=30,50, or as `engram info ID "
          "--json` prints it (repeatable; `engram info ID` lists them)")
      .type_name("NAME=VALUE");
}

MakeOptions batch_options(int num_envs, int threads) {
  MakeOptions options;
  options.num_envs = num_envs;
  options.threads = threads;
  return options;
}

void add_filter(const Command& command, TaskFilter& filter) {
  add_split(command, filter.split);
  command.add_option("--family", filter.family, "Tasks of this family only").type_name("FAMILY");
}

std::vector<const RegistryEntry*> select(const TaskFilter& filter) {
  std::vector<const RegistryEntry*> selected;
  std::vector<std::string_view> families;
  for (const RegistryEntry* entry : all_entries()) {
    if (families.empty() || families.back() != entry->family) families.push_back(entry->family);
    if (filter.split && entry->split != *filter.split) continue;
    if (!filter.family.empty() && entry->family != filter.family) continue;
    if (filter.canonical && !entry->canonical) continue;
    selected.push_back(entry);
  }
  std::sort(families.begin(), families.end());
  families.erase(std::unique(families.begin(), families.end()), families.end());
  if (!filter.family.empty() &&
      std::find(families.begin(), families.end(), filter.family) == families.end()) {
    refuse("--family", filter.family, fmt::format("{}", fmt::join(families, ", ")));
  }
  return selected;
}

}  // namespace engram::apps
