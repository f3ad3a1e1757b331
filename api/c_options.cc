#include "api/c_options.h"

#include <optional>
#include <string>

#include "api/c_convert.h"
#include "protocol/make/variants.h"

namespace engram::c {
namespace {

// An array that may be NULL if it is empty.
template <class T>
std::span<const T> array(const char* what, const T* values, std::size_t count) {
  if (values == nullptr && count > 0) {
    refuse(what, "NULL", std::to_string(count) + " values needed");
  }
  return {values, count};
}

std::vector<std::string> to_cameras(const engram_options& options) {
  std::vector<std::string> cameras;
  for (const char* name : array("cameras", options.cameras, options.num_cameras)) {
    cameras.emplace_back(text("name of a camera", name));
  }
  return cameras;
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
  // begin generated: defaults (tools/surface, from api/surface.toml)
  options.num_envs = 1;
  options.threads = 0;
  options.chunk = 0;
  options.substeps = 5;
  options.seed = 0;
  options.obs_mode = ENGRAM_OBS_STATE;
  options.reward_mode = ENGRAM_REWARD_NORMALIZED_DENSE;
  options.auto_reset = ENGRAM_AUTO_RESET_NEXT_STEP;
  options.control_mode = nullptr;
  options.rotation_sign = -1;
  options.freeze_cue = 1;
  options.terminate_on_success = -1;
  options.sleep = 1;
  options.robot_init_qpos_noise = 0.02;
  options.observe_time = 0;
  options.joint_proprio = 0;
  options.lanes = 0;
  options.rules = ENGRAM_RULES_REFERENCE;
  options.image_width = 128;
  options.image_height = 128;
  options.renderer = "cpu";
  options.shadows = 0;
  options.antialias = 0;
  options.render_shadows = 0;
  options.terminate_on_failure = 1;
  options.after_end = ENGRAM_AFTER_END_HOLD;
  options.max_episode_steps = 0;
  options.physics = ENGRAM_PHYSICS_ENGRAM;
  // end generated
  return options;
}

MakeOptions to_make_options(const engram_options& options) {
  check_struct_size(options);
  MakeOptions out;
  // begin generated: conversions
  convert("num_envs", options.num_envs, out.num_envs);
  convert("seed", options.seed, out.seed);
  convert("threads", options.threads, out.threads);
  convert("chunk", options.chunk, out.chunk);
  convert("obs_mode", options.obs_mode, out.obs_mode);
  convert("observe_time", options.observe_time, out.observe_time);
  convert("joint_proprio", options.joint_proprio, out.joint_proprio);
  convert("reward_mode", options.reward_mode, out.reward_mode);
  convert("control_mode", options.control_mode, out.control_mode);
  convert("auto_reset", options.auto_reset, out.auto_reset);
  convert("rotation_sign", options.rotation_sign, out.rotation_sign);
  convert("freeze_cue", options.freeze_cue, out.freeze_cue);
  convert("terminate_on_success", options.terminate_on_success, out.terminate_on_success);
  convert("robot_init_qpos_noise", options.robot_init_qpos_noise, out.robot_init_qpos_noise);
  convert("sleep", options.sleep, out.sleep);
  convert("lanes", options.lanes, out.lanes);
  convert("substeps", options.substeps, out.substeps);
  convert("rules", options.rules, out.rules);
  convert("image_width", options.image_width, out.images.width);
  convert("image_height", options.image_height, out.images.height);
  convert("renderer", options.renderer, out.image_options.renderer);
  convert("shadows", options.shadows, out.image_options.shadows);
  convert("antialias", options.antialias, out.image_options.antialias);
  convert("render_shadows", options.render_shadows, out.render_options.shadows);
  convert("terminate_on_failure", options.terminate_on_failure, out.terminate_on_failure);
  convert("after_end", options.after_end, out.after_end);
  convert("max_episode_steps", options.max_episode_steps, out.max_episode_steps);
  convert("physics", options.physics, out.physics);
  // end generated
  out.pins = to_pins(options.pins, options.num_pins);
  if (options.constants != nullptr) out.constants = parse_constants(options.constants);
  out.task_options = to_choices(options.task_options, options.num_task_options);
  out.perturbations = to_perturbations(options.perturbations, options.num_perturbations);
  const bool default_cameras = options.cameras == nullptr && options.num_cameras == 0;
  if (!default_cameras) out.images.cameras = to_cameras(options);
  return out;
}

std::vector<TaskOptionValue> to_choices(const engram_task_option* choices, std::size_t count) {
  std::vector<TaskOptionValue> all;
  for (const engram_task_option& choice : array("task_options", choices, count)) {
    all.push_back({text("name of a task option", choice.name), choice.value});
  }
  return all;
}

std::vector<PerturbationLevel> to_perturbations(const engram_perturbation* perturbations,
                                                std::size_t count) {
  std::vector<PerturbationLevel> all;
  for (const engram_perturbation& one : array("perturbations", perturbations, count)) {
    all.push_back({require_axis(text("axis of a perturbation", one.axis)), one.level});
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

GivenReset::GivenReset(const engram_reset_request* request, int num_envs) {
  if (request == nullptr) return;
  const auto count = static_cast<std::size_t>(num_envs);
  if (request->mask != nullptr) request_.mask = {request->mask, count};
  if (request->seeds != nullptr) request_.seeds = {request->seeds, count};
  if (request->has_pins != 0) {
    pins_ = to_pins(request->pins, request->num_pins);
    request_.pins = &pins_;
  }
  if (request->constants != nullptr) {
    constants_ = parse_constants(request->constants);
    request_.constants = &constants_;
  }
}

Policy to_policy(std::int32_t policy) {
  Policy chosen{};
  convert("policy", policy, chosen);
  return chosen;
}

// begin generated: asserts
static_assert(static_cast<int>(ObsMode::kNone) == ENGRAM_OBS_NONE);
static_assert(static_cast<int>(ObsMode::kState) == ENGRAM_OBS_STATE);
static_assert(static_cast<int>(ObsMode::kStateDict) == ENGRAM_OBS_STATE_DICT);
static_assert(static_cast<int>(ObsMode::kRgb) == ENGRAM_OBS_RGB);
static_assert(static_cast<int>(ObsMode::kObjects) == ENGRAM_OBS_OBJECTS);
static_assert(static_cast<int>(ObsMode::kObjectsDict) == ENGRAM_OBS_OBJECTS_DICT);
static_assert(static_cast<int>(ObsMode::kRgbDepth) == ENGRAM_OBS_RGB_DEPTH);
static_assert(static_cast<int>(ObsMode::kRgbSegmentation) == ENGRAM_OBS_RGB_SEGMENTATION);
static_assert(static_cast<int>(ObsMode::kRgbDepthSegmentation) ==
              ENGRAM_OBS_RGB_DEPTH_SEGMENTATION);
static_assert(static_cast<int>(ObsMode::kRgbState) == ENGRAM_OBS_RGB_STATE);
static_assert(static_cast<int>(ObsMode::kRgbDepthState) == ENGRAM_OBS_RGB_DEPTH_STATE);
static_assert(static_cast<int>(ObsMode::kRgbSegmentationState) ==
              ENGRAM_OBS_RGB_SEGMENTATION_STATE);
static_assert(static_cast<int>(ObsMode::kRgbDepthSegmentationState) ==
              ENGRAM_OBS_RGB_DEPTH_SEGMENTATION_STATE);
static_assert(static_cast<int>(ObsMode::kRgbObjects) == ENGRAM_OBS_RGB_OBJECTS);
static_assert(static_cast<int>(ObsMode::kRgbDepthObjects) == ENGRAM_OBS_RGB_DEPTH_OBJECTS);
static_assert(static_cast<int>(ObsMode::kRgbSegmentationObjects) ==
              ENGRAM_OBS_RGB_SEGMENTATION_OBJECTS);
static_assert(static_cast<int>(ObsMode::kRgbDepthSegmentationObjects) ==
              ENGRAM_OBS_RGB_DEPTH_SEGMENTATION_OBJECTS);
static_assert(static_cast<int>(RewardMode::kNone) == ENGRAM_REWARD_NONE);
static_assert(static_cast<int>(RewardMode::kSparse) == ENGRAM_REWARD_SPARSE);
static_assert(static_cast<int>(RewardMode::kDense) == ENGRAM_REWARD_DENSE);
static_assert(static_cast<int>(RewardMode::kNormalizedDense) == ENGRAM_REWARD_NORMALIZED_DENSE);
static_assert(static_cast<int>(AutoReset::kNextStep) == ENGRAM_AUTO_RESET_NEXT_STEP);
static_assert(static_cast<int>(AutoReset::kSameStep) == ENGRAM_AUTO_RESET_SAME_STEP);
static_assert(static_cast<int>(AutoReset::kOff) == ENGRAM_AUTO_RESET_OFF);
static_assert(static_cast<int>(AfterEnd::kHold) == ENGRAM_AFTER_END_HOLD);
static_assert(static_cast<int>(AfterEnd::kContinue) == ENGRAM_AFTER_END_CONTINUE);
static_assert(static_cast<int>(AfterEnd::kRefuse) == ENGRAM_AFTER_END_REFUSE);
static_assert(static_cast<int>(Policy::kZero) == ENGRAM_POLICY_ZERO);
static_assert(static_cast<int>(Policy::kRandom) == ENGRAM_POLICY_RANDOM);
static_assert(static_cast<int>(Policy::kOracle) == ENGRAM_POLICY_ORACLE);
static_assert(static_cast<int>(Policy::kBlind) == ENGRAM_POLICY_BLIND);
static_assert(static_cast<int>(Policy::kSweep) == ENGRAM_POLICY_SWEEP);
static_assert(static_cast<int>(Rules::kReference) == ENGRAM_RULES_REFERENCE);
static_assert(static_cast<int>(Rules::kOriginal) == ENGRAM_RULES_ORIGINAL);
static_assert(static_cast<int>(Physics::kEngram) == ENGRAM_PHYSICS_ENGRAM);
static_assert(static_cast<int>(Physics::kMujoco) == ENGRAM_PHYSICS_MUJOCO);
// end generated

TaskShare to_share(const engram_task_share& share) {
  TaskShare task{text("id of a task", share.id), share.num_envs};
  if (share.num_envs < 1 || share.num_envs > kMaxNumEnvs) {
    refuse("number of environments of " + task.id, std::to_string(share.num_envs),
           "1 to " + std::to_string(kMaxNumEnvs) + " allowed");
  }
  if (share.constants != nullptr) task.constants = parse_constants(share.constants);
  task.pins = to_pins(share.pins, share.num_pins);
  task.task_options = to_choices(share.task_options, share.num_task_options);
  return task;
}

std::vector<std::vector<OutputTarget>> to_turns(const engram_output_target* targets,
                                                std::size_t turns, std::size_t count) {
  std::vector<std::vector<OutputTarget>> all;
  for (std::size_t turn = 0; turn < turns; ++turn) {
    std::vector<OutputTarget>& own = all.emplace_back();
    if (count == 0) continue;
    for (const engram_output_target& target : array("targets", targets + turn * count, count)) {
      own.push_back({text("name of an output", target.name), target.data, target.size});
    }
  }
  return all;
}

}  // namespace engram::c
