#include "api/c_options.h"

#include <algorithm>
#include <string>

#include "core/base/error.h"
#include "core/physics/controller.h"

namespace engram::c {
namespace {

[[noreturn]] void refuse(const std::string& what, const std::string& given,
                         const std::string& allowed) {
  throw Error(Error::kInvalidArgument, what + ": " + given + " given, " + allowed);
}

// A number of 0 to count - 1, which counts the values of an enum.
template <class Enum>
Enum enumerator(const char* what, std::int32_t value, std::int32_t count) {
  if (value < 0 || value >= count) {
    refuse(what, std::to_string(value), "0 to " + std::to_string(count - 1) + " allowed");
  }
  return static_cast<Enum>(value);
}

bool truth(const char* what, std::int32_t value) {
  if (value != 0 && value != 1) refuse(what, std::to_string(value), "0 or 1 allowed");
  return value == 1;
}

const char* text(const std::string& what, const char* value) {
  if (value == nullptr) refuse(what, "NULL", "a text needed");
  return value;
}

// An array that may be NULL if it is empty.
template <class T>
std::span<const T> array(const char* what, const T* values, std::size_t count) {
  if (values == nullptr && count > 0) {
    refuse(what, "NULL", std::to_string(count) + " values needed");
  }
  return {values, count};
}

ControlMode control_mode(const char* name) {
  const std::optional<ControlMode> mode = find_control_mode(text("control_mode", name));
  if (mode) return *mode;
  std::string names;
  for (int i = 0; i < kControlModes; ++i) {
    names +=
        (names.empty() ? "" : ", ") + std::string(control_mode_name(static_cast<ControlMode>(i)));
  }
  throw Error(Error::kUnknownId,
              "no control mode named '" + std::string(name) + "'; allowed are: " + names);
}

std::optional<bool> optional_truth(const char* what, std::int32_t value) {
  if (value < -1 || value > 1) refuse(what, std::to_string(value), "-1, 0 or 1 allowed");
  return value < 0 ? std::nullopt : std::optional<bool>(value == 1);
}

ImageShape to_images(const engram_options& options) {
  ImageShape images;
  images.width = options.image_width;
  images.height = options.image_height;
  if (options.cameras == nullptr && options.num_cameras == 0) return images;
  images.cameras.clear();
  for (const char* name : array("cameras", options.cameras, options.num_cameras)) {
    images.cameras.emplace_back(text("name of a camera", name));
  }
  return images;
}

void check_struct_size(const engram_options& options) {
  if (options.struct_size == sizeof(engram_options)) return;
  refuse("options.struct_size", std::to_string(options.struct_size),
         std::to_string(sizeof(engram_options)) + " needed; call engram_options_init first");
}

}  // namespace

engram_options default_options() noexcept {
  engram_options options{};
  options.struct_size = sizeof options;
  options.num_envs = 1;
  options.substeps = 5;
  options.obs_mode = ENGRAM_OBS_STATE;
  options.reward_mode = ENGRAM_REWARD_NORMALIZED_DENSE;
  options.auto_reset = ENGRAM_AUTO_RESET_NEXT_STEP;
  options.control_mode = "pd_ee_delta_pose";
  options.rotation_sign = -1;
  options.freeze_cue = 1;
  options.terminate_on_success = -1;
  options.sleep = 1;
  options.robot_init_qpos_noise = 0.02;
  options.image_width = 128;
  options.image_height = 128;
  options.renderer = "cpu";
  return options;
}

EnvOptions to_env_options(const engram_options& options) {
  check_struct_size(options);
  EnvOptions out;
  out.num_envs = options.num_envs;
  out.seed = options.seed;
  out.threads = options.threads;
  out.chunk = options.chunk;
  out.obs_mode = enumerator<ObsMode>("obs_mode", options.obs_mode, 4);
  out.reward_mode = enumerator<RewardMode>("reward_mode", options.reward_mode, 4);
  out.control_mode = control_mode(options.control_mode);
  out.auto_reset = enumerator<AutoReset>("auto_reset", options.auto_reset, 3);
  out.rotation_sign = options.rotation_sign;
  out.freeze_cue = truth("freeze_cue", options.freeze_cue);
  out.terminate_on_success = optional_truth("terminate_on_success", options.terminate_on_success);
  out.robot_init_qpos_noise = options.robot_init_qpos_noise;
  out.sleep = truth("sleep", options.sleep);
  out.substeps = options.substeps;
  out.pins = to_pins(options.pins, options.num_pins);
  out.task_options = to_choices(options.task_options, options.num_task_options);
  out.images = to_images(options);
  out.image_options.renderer = text("renderer", options.renderer);
  out.image_options.shadows = truth("shadows", options.shadows);
  out.image_options.antialias = truth("antialias", options.antialias);
  return out;
}

std::vector<OptionChoice> to_choices(const engram_task_option* choices, std::size_t count) {
  std::vector<OptionChoice> all;
  for (const engram_task_option& choice : array("task_options", choices, count)) {
    all.push_back({text("name of a task option", choice.name), choice.value});
  }
  return all;
}

std::vector<Pin> to_pins(const engram_pin* pins, std::size_t count) {
  constexpr std::size_t kMaxWidth = 4096;  // more than any draw has
  std::vector<Pin> all;
  for (const engram_pin& pin : array("pins", pins, count)) {
    const std::string name = text("name of a pin", pin.name);
    const std::string what = "pin '" + name + "'";
    if (pin.count > kMaxWidth) {
      refuse(what, std::to_string(pin.count) + " values", "fewer needed");
    }
    const std::span<const double> values = array(what.c_str(), pin.values, pin.count);
    all.push_back({name, {values.begin(), values.end()}});
  }
  return all;
}

Policy to_policy(std::int32_t policy) { return enumerator<Policy>("policy", policy, 4); }

static_assert(static_cast<int>(ObsMode::kNone) == ENGRAM_OBS_NONE);
static_assert(static_cast<int>(ObsMode::kState) == ENGRAM_OBS_STATE);
static_assert(static_cast<int>(ObsMode::kStateDict) == ENGRAM_OBS_STATE_DICT);
static_assert(static_cast<int>(ObsMode::kRgb) == ENGRAM_OBS_RGB);
static_assert(static_cast<int>(RewardMode::kNone) == ENGRAM_REWARD_NONE);
static_assert(static_cast<int>(RewardMode::kSparse) == ENGRAM_REWARD_SPARSE);
static_assert(static_cast<int>(RewardMode::kDense) == ENGRAM_REWARD_DENSE);
static_assert(static_cast<int>(RewardMode::kNormalizedDense) == ENGRAM_REWARD_NORMALIZED_DENSE);
static_assert(static_cast<int>(AutoReset::kNextStep) == ENGRAM_AUTO_RESET_NEXT_STEP);
static_assert(static_cast<int>(AutoReset::kSameStep) == ENGRAM_AUTO_RESET_SAME_STEP);
static_assert(static_cast<int>(AutoReset::kOff) == ENGRAM_AUTO_RESET_OFF);
static_assert(static_cast<int>(Policy::kZero) == ENGRAM_POLICY_ZERO);
static_assert(static_cast<int>(Policy::kRandom) == ENGRAM_POLICY_RANDOM);
static_assert(static_cast<int>(Policy::kOracle) == ENGRAM_POLICY_ORACLE);
static_assert(static_cast<int>(Policy::kBlind) == ENGRAM_POLICY_BLIND);

}  // namespace engram::c
