#include "protocol/eval/run/settings.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <limits>
#include <type_traits>

#include "protocol/io/json_checksum.h"
#include "protocol/io/json_values.h"
#include "protocol/make/control_mode_choice.h"
#include "protocol/make/definitions.h"
#include "protocol/make/make.h"
#include "protocol/make/perturbations_document.h"
#include "protocol/make/physics_keys.h"
#include "protocol/make/variants.h"

namespace engram {
namespace {

// Variants among these tasks.
JsonList variants_of(const std::vector<std::string>& ids) {
  JsonList variants;
  for (const std::string& id : ids) {
    const RegistryEntry& entry = require_entry(id);
    if (entry.constants != nullptr) variants.push_back(to_document(variant_of(entry)));
  }
  return variants;
}

// A sealed run has no seed before it is opened.
void read_seeds(const Json& document, EvaluationSettings& settings) {
  const Json& commitment = part(document, "sealed");
  if (is_null(commitment)) {
    settings.start_seed = whole_number(part(document, "start_seed"));
    return;
  }
  settings.set_commitment(SeedCommitment::of_hash(text(part(commitment, "sha256"))));
  if (is_null(part(commitment, "secret"))) return;
  SeedCommitment known(text(part(commitment, "secret")));
  if (known.hash() != settings.commitment->hash()) {
    throw Error(Error::kIo, "the hash is not that of the secret seed");
  }
  settings.set_commitment(std::move(known));
  settings.revealed = true;
}

// Values under keys that older documents do not have; without one they stay as they are.

void read(const Json& document, const char* key, bool& value) {
  if (const Json* found = find(document, key)) value = truth(*found);
}

void read(const Json& document, const char* key, std::uint64_t& value) {
  if (const Json* found = find(document, key)) value = whole_number(*found);
}

void read(const Json& document, const char* key, int low, int high, int& value) {
  const Json* found = find(document, key);
  if (found == nullptr) return;
  value = static_cast<int>(whole_number(*found, static_cast<std::uint64_t>(high)));
  if (value >= low) return;
  throw Error(Error::kIo, "'" + std::string(key) + "' is " + std::to_string(value));
}

template <class Enum>
requires std::is_enum_v<Enum>
void read(const Json& document, const char* key, Enum& value) {
  if (const Json* found = find(document, key)) value = require_named<Enum>(key, text(*found));
}

// Older documents have none.
std::vector<PerturbationLevel> read_perturbations(const Json& document) {
  std::vector<PerturbationLevel> levels;
  const Json* value = find(document, "perturbations");
  if (value == nullptr || is_null(*value)) return levels;
  for (const auto& [axis, level] : table(*value)) {
    levels.push_back({require_axis(axis), number(level)});
  }
  check_perturbations(levels);
  return levels;
}

EvaluationSettings read(const Json& document) {
  EvaluationSettings settings;
  for (const Json& id : list(part(document, "tasks"))) settings.tasks.push_back(text(id));
  settings.episodes =
      static_cast<int>(whole_number(part(document, "n_episodes"), std::numeric_limits<int>::max()));
  read_seeds(document, settings);
  settings.obs_mode = require_named<ObsMode>("observation mode", text(part(document, "obs_mode")));
  settings.renderer = text(part(document, "renderer"));
  settings.control_mode =
      require_named<ControlMode>("control mode", text(part(document, "control_mode")));
  settings.policy = text(part(document, "policy"));
  settings.policy_config = part(document, "policy_config");
  if (!is_null(settings.policy_config)) (void)table(settings.policy_config);
  settings.rules = require_named<Rules>("rules", text(part(document, "rules")));
  for (const auto& [name, value] : table(part(document, "task_options"))) {
    settings.task_options[name] = number(value);
  }
  settings.constants = table(part(document, "constants"));
  settings.perturbations = read_perturbations(document);
  // begin generated: reads (tools/surface, from api/surface.toml)
  read(document, "tell_episodes", settings.tell_episodes);
  read(document, "repeat", 1, kMaxRepeat, settings.repeat);
  read(document, "policy_seed", settings.policy_seed);
  read(document, "latency_steps", 0, kMaxLatency, settings.latency);
  read(document, "joint_proprio", settings.joint_proprio);
  read(document, "choices", settings.choices);
  read(document, "choices_stride", 1, kMaxChoicesStride, settings.choices_stride);
  read(document, "physics", settings.physics);
  // end generated
  check_rounds(settings.episodes, settings.repeat);
  std::vector<TaskVariant> variants;
  for (const Json& variant : list(part(document, "variants"))) {
    variants.push_back(to_variant(variant, "variants"));
  }
  register_variants(variants);
  return settings;
}

// Another version gives other results for the same seeds.
void require_this_version(const Json& document, const std::filesystem::path& file) {
  const Json* found = find(document, "version");
  const std::string given = found == nullptr ? "0.1.0 or older" : text(*found);
  if (given == version()) return;
  throw Error(Error::kIo, "'" + file.string() + "' is of engram " + given +
                              ", and this is engram " + version() +
                              ": its results cannot be mixed with those; choose another folder");
}

// So does another version of MuJoCo, where it is the physics.
void require_this_mujoco(const Json& document, Physics physics) {
  const Json given = value_or_null(document, kMujocoVersionKey);
  const Json now = mujoco_version_of(physics);
  if (given == now) return;
  throw Error(Error::kIo,
              std::string(kMujocoVersionKey) + " is " + to_line(given) + ", here " + to_line(now));
}

}  // namespace

void EvaluationSettings::set_environment(const MakeOptions& environment) {
  obs_mode = environment.obs_mode;
  renderer = obs_mode == ObsMode::kRgb ? environment.image_options.renderer : "none";
  std::vector<const RegistryEntry*> entries;
  for (const std::string& id : tasks) entries.push_back(&require_entry(id));
  control_mode = common_control_mode(environment.control_mode, entries);
  // begin generated: environment
  rules = environment.rules;
  constants = environment.constants;
  joint_proprio = environment.joint_proprio;
  perturbations = environment.perturbations;
  physics = environment.physics;
  // end generated
  task_options.clear();
  for (const TaskOptionValue& choice : environment.task_options) {
    task_options[choice.name] = choice.value;
  }
}

void EvaluationSettings::set_commitment(SeedCommitment seed) {
  if (seed.has_secret()) start_seed = seed.start_seed();
  commitment = std::move(seed);
}

Json EvaluationSettings::commitment_document() const {
  if (!commitment) return {};
  return JsonTable{{"sha256", commitment->hash()},
                   {"secret", revealed ? Json(commitment->secret()) : Json()}};
}

Json EvaluationSettings::document() const {
  JsonTable document{
      {"version", version()},
      {"tasks", JsonList(tasks.begin(), tasks.end())},
      {"n_episodes", episodes},
      {"start_seed", tells_seeds() ? Json(start_seed) : Json()},
      {"sealed", commitment_document()},
      {"tell_episodes", tell_episodes},
      {"obs_mode", name_of(obs_mode)},
      {"renderer", renderer},
      {"control_mode", name_of(control_mode)},
      {"joint_proprio", joint_proprio},
      {"policy", policy},
      {"policy_config", policy_config},
      {"rules", name_of(rules)},
      {"task_options", JsonTable(task_options.begin(), task_options.end())},
      {"constants", constants},
      {"perturbations", perturbations_document(perturbations)},
      {"variants", variants_of(tasks)},
      // begin generated: document
      {"repeat", repeat},
      {"policy_seed", policy_seed},
      {"latency_steps", latency},
      {"choices", choices},
      {"choices_stride", choices_stride},
      {"physics", name_of(physics)},
      // end generated
  };
  Json mujoco = mujoco_version_of(physics);
  if (!is_null(mujoco)) document.emplace_back(kMujocoVersionKey, std::move(mujoco));
  JsonTable definitions = definitions_of(tasks);
  if (!definitions.empty()) document.emplace_back("definitions", std::move(definitions));
  add_checksum(document);
  return document;
}

EvaluationSettings EvaluationSettings::of(const Json& document, const std::filesystem::path& file) {
  EvaluationSettings settings;
  require_this_version(document, file);
  try {
    if (!has_valid_checksum(document)) throw Error(Error::kIo, "its checksum does not fit");
    settings = read(document);
    require_this_mujoco(document, settings.physics);
  } catch (const Error& error) {
    throw Error(Error::kIo, "'" + file.string() + "' is not what an evaluation wrote (" +
                                error.what() + "); remove it to give the settings anew");
  }
  require_definitions(settings.tasks, value_or_null(document, "definitions"),
                      "'" + file.string() + "'");
  return settings;
}

void require_custom_name(std::string_view option, std::string_view name) {
  const auto lower = [](unsigned char letter) { return std::tolower(letter); };
  const bool own = std::ranges::any_of(names_of(Policy{}), [&](std::string_view policy) {
    return std::ranges::equal(name, policy, {}, lower, lower);
  });
  if (!own) return;
  throw Error(Error::kInvalidArgument, std::string(option) + ": '" + std::string(name) +
                                           "' given, the name of one of engram's own policies; "
                                           "another name needed");
}

void check_rounds(int episodes, int repeat) {
  const std::int64_t all = std::int64_t{episodes} * repeat;
  if (all <= std::numeric_limits<int>::max()) return;
  throw Error(Error::kInvalidArgument, std::to_string(repeat) + " rounds of " +
                                           std::to_string(episodes) + " episodes given, at most " +
                                           std::to_string(std::numeric_limits<int>::max()) +
                                           " episodes in all allowed");
}

int parse_latency(std::string_view option, const std::string& text) {
  const std::string_view whole(text);
  const bool timed = whole.ends_with("ms");
  const std::string_view digits = timed ? whole.substr(0, whole.size() - 2) : whole;
  double value = -1;
  const char* const end = digits.data() + digits.size();
  const bool plain =
      digits.find_first_not_of(timed ? "0123456789." : "0123456789") == std::string_view::npos;
  const auto [rest, error] = std::from_chars(digits.data(), end, value);
  const double steps = timed ? std::ceil(value / kControlStepMilliseconds) : value;
  if (!plain || error != std::errc() || rest != end || !(steps >= 0 && steps <= kMaxLatency)) {
    throw Error(Error::kInvalidArgument,
                std::string(option) + ": '" + text + "' given, 0 to " +
                    std::to_string(kMaxLatency) +
                    " control steps of 50 ms, or milliseconds such as 120ms, allowed");
  }
  return static_cast<int>(steps);
}

std::vector<std::string> ids_in_order(std::vector<const RegistryEntry*> tasks) {
  std::ranges::sort(tasks, {}, &RegistryEntry::index);
  std::vector<std::string> ids;
  ids.reserve(tasks.size());
  for (const RegistryEntry* task : tasks) ids.emplace_back(task->id);
  return ids;
}

Protocol protocol_of(const EvaluationSettings& settings) {
  Protocol protocol;
  static_cast<RunOptions&>(protocol) = settings;
  if (settings.commitment) protocol.number_key = settings.commitment->secret();
  MakeOptions& environment = protocol.environment;
  environment.obs_mode = settings.obs_mode;
  if (environment.obs_mode == ObsMode::kRgb) {
    environment.image_options.renderer = settings.renderer;
  }
  environment.control_mode = settings.control_mode;
  // begin generated: environment_back
  environment.rules = settings.rules;
  environment.constants = settings.constants;
  environment.joint_proprio = settings.joint_proprio;
  environment.perturbations = settings.perturbations;
  environment.physics = settings.physics;
  // end generated
  for (const auto& [name, value] : settings.task_options) {
    environment.task_options.push_back({name, value});
  }
  return protocol;
}

}  // namespace engram
