// Options of a batch, and of the task that it runs. tools/surface writes most of this from
// api/surface.toml, where all options and names are listed.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "core/base/constant.h"
#include "core/base/names.h"
#include "core/image/image_options.h"
#include "core/perturb/perturbation.h"
#include "core/sim/control_mode.h"
#include "core/task/episode.h"
#include "core/task/rules.h"
#include "core/task/task_option.h"

namespace engram {

// begin generated: enums
// Contents of observations.
enum class ObsMode {
  kNone,
  // One row of floats, in "observation".
  kState,
  // One row; the description of the batch names its parts.
  kStateDict,
  // Images in "rgb" and "proprio"; "observation", which would reveal the hidden quantity, stays
  // empty.
  kRgb,
  // One row of floats, in "observation": the robot, and what cameras can show of the objects;
  // nothing that is hidden.
  kObjects,
  // One row; the description of the batch names its parts.
  kObjectsDict,
  // Rgb, and "depth": mm along the axis of the camera to what each pixel shows.
  kRgbDepth,
  // Rgb, and "segmentation": an index for each pixel; the description of the batch names the
  // values.
  kRgbSegmentation,
  // Rgb, and both.
  kRgbDepthSegmentation,
  // Images, and the row of the state in "observation", for critics and teachers.
  kRgbState,
  kRgbDepthState,
  kRgbSegmentationState,
  kRgbDepthSegmentationState,
  // Images, and the row of objects in "observation".
  kRgbObjects,
  kRgbDepthObjects,
  kRgbSegmentationObjects,
  kRgbDepthSegmentationObjects,
};
inline constexpr std::array kObsModeNames = {
    "none",
    "state",
    "state_dict",
    "rgb",
    "objects",
    "objects_dict",
    "rgb+depth",
    "rgb+segmentation",
    "rgb+depth+segmentation",
    "rgb+state",
    "rgb+depth+state",
    "rgb+segmentation+state",
    "rgb+depth+segmentation+state",
    "rgb+objects",
    "rgb+depth+objects",
    "rgb+segmentation+objects",
    "rgb+depth+segmentation+objects",
};
constexpr const auto& names_of(ObsMode) { return kObsModeNames; }

enum class RewardMode {
  kNone,
  // 1 in steps with success.
  kSparse,
  // The task's shaped reward.
  kDense,
  // The shaped reward, divided by its value at success.
  kNormalizedDense,
};
inline constexpr std::array kRewardModeNames = {"none", "sparse", "dense", "normalized_dense"};
constexpr const auto& names_of(RewardMode) { return kRewardModeNames; }

// Treatment of an environment whose episode has ended, in Gymnasium's terms.
enum class AutoReset {
  // The next step ignores its action and returns the first observation of a new episode.
  kNextStep,
  // That step returns the first observation of a new episode; the last outputs of the episode are
  // kept as final outputs.
  kSameStep,
  // It waits for a reset; the option after_end says what steps do meanwhile.
  kOff,
};
inline constexpr std::array kAutoResetNames = {"next-step", "same-step", "off"};
constexpr const auto& names_of(AutoReset) { return kAutoResetNames; }

// Effect of a step on an environment whose episode has ended, where nothing resets it.
enum class AfterEnd {
  kHold,      // it keeps its last outputs, with reward 0, until it is reset
  kContinue,  // it is simulated on; success, reward and endings are reported as in any step
  kRefuse,    // steps are refused until it is reset
};
inline constexpr std::array kAfterEndNames = {"hold", "continue", "refuse"};
constexpr const auto& names_of(AfterEnd) { return kAfterEndNames; }

// Source of the actions that the batch itself chooses.
enum class Policy {
  kZero,
  // Uniform over the action space.
  kRandom,
  // Solves the task with privileged state; pd_ee_delta_pose, pd_joint_pos and pd_joint_delta_pos
  // only.
  kOracle,
  // The oracle, but with the hidden quantity guessed.
  kBlind,
  // The best that can be done without memory.
  kSweep,
};
inline constexpr std::array kPolicyNames = {"zero", "random", "oracle", "blind", "sweep"};
constexpr const auto& names_of(Policy) { return kPolicyNames; }

// Engine that moves robot and props.
enum class Physics {
  kEngram,  // engram's own, which follows the original's
  kMujoco,  // MuJoCo's own step, one mjData per environment
};
inline constexpr std::array kPhysicsNames = {"engram", "mujoco"};
constexpr const auto& names_of(Physics) { return kPhysicsNames; }
// end generated

// Contents of a mode's observations, which its name lists.
struct ObservedParts {
  bool state;    // a row of the state, which shows the hidden quantity
  bool objects;  // a row of tokens, which shows no more than cameras do
  bool images;
  bool depth;         // beside colours
  bool segmentation;  // beside colours
};
inline constexpr auto kObservedParts = [] {
  std::array<ObservedParts, kObsModeNames.size()> parts{};
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const auto has = [name = std::string_view(kObsModeNames[i])](std::string_view part) {
      return name.find(part) != std::string_view::npos;
    };
    parts[i] = {has("state"), has("objects"), has("rgb"), has("depth"), has("segmentation")};
  }
  return parts;
}();

constexpr const ObservedParts& parts_of(ObsMode mode) {
  return kObservedParts[static_cast<std::size_t>(mode)];
}
constexpr bool observes_state(ObsMode mode) { return parts_of(mode).state; }
constexpr bool observes_objects(ObsMode mode) { return parts_of(mode).objects; }
constexpr bool observes_images(ObsMode mode) { return parts_of(mode).images; }
constexpr bool observes_depth(ObsMode mode) { return parts_of(mode).depth; }
constexpr bool observes_segmentation(ObsMode mode) { return parts_of(mode).segmentation; }

// begin generated: limits
inline constexpr int kMaxNumEnvs = 1'000'000;
inline constexpr int kMaxThreads = 1024;
inline constexpr int kMaxSubsteps = 1000;
inline constexpr int kMaxMaxEpisodeSteps = 1'000'000;
// end generated

struct BatchOptions {
  // begin generated: fields
  // Number of environments. 1 to 1,000,000.
  int num_envs = 1;
  // Environment i has seed + i.
  std::uint64_t seed = 0;
  // Threads that work on a step, the caller's included; results do not depend on it. 0 (one per
  // core) to 1024.
  int threads = 0;
  // Most environments that a thread claims at a time. 0 (chosen) or more.
  int chunk = 0;
  // Contents of observations.
  ObsMode obs_mode = ObsMode::kState;
  // Objects modes: elapsed time in observations, as a share of the horizon.
  bool observe_time = false;
  // Proprio has the arm's seven joint angles and the gripper's opening, instead of the TCP's pose
  // and the opening.
  bool joint_proprio = false;
  // The reward of a step.
  RewardMode reward_mode = RewardMode::kNormalizedDense;
  // Meaning of actions.
  std::optional<ControlMode> control_mode = std::nullopt;
  // Treatment of an environment whose episode has ended.
  AutoReset auto_reset = AutoReset::kNextStep;
  // Sign of rotation actions; -1 as the original benchmark has it. -1 or 1.
  int rotation_sign = -1;
  // Actions are replaced by zeros during cue and empty phase, where the canonical wrapper chain
  // does so.
  bool freeze_cue = true;
  // End of episodes at success, whatever the task's own rule.
  std::optional<bool> terminate_on_success = std::nullopt;
  // Standard deviation of the arm joints' noise in the start pose. 0 to 1 rad.
  double robot_init_qpos_noise = 0.02;
  // Shortcuts of the physics; off: none of them, for comparison.
  bool sleep = true;
  // Environments whose robots move side by side in vector registers: 1, 4, 8 or 16; results are the
  // same. 0, 1, 4, 8 or 16.
  int lanes = 0;
  // Physics steps of 0.01 s per control step; 0 measures everything but physics. 0 to 1000.
  int substeps = 5;
  // Quantities of every episode that are fixed instead of drawn.
  std::vector<Pin> pins = {};
  // Variants of the task's rules, by name.
  std::vector<TaskOptionValue> task_options = {};
  // Rule set of the task: the default of every task option; task_options win.
  Rules rules = Rules::kReference;
  // End of episodes at failure, where the task's rule has it; off, with terminate_on_success off as
  // well: at the horizon only.
  bool terminate_on_failure = true;
  // Auto-reset off: effect of a step on an environment whose episode has ended.
  AfterEnd after_end = AfterEnd::kHold;
  // Departures from the task's usual scene, robot and words, by axis, from 0 (none) to 1:
  // docs/variants.md.
  std::vector<PerturbationLevel> perturbations = {};
  // Engine that moves robot and props.
  Physics physics = Physics::kEngram;
  // end generated
  // Further random numbers for the policies random and blind: of the episode's seed and this one.
  std::uint64_t policy_seed = 0;
  ImageShape images = {};                 // of rgb observations
  ImageSourceOptions image_options = {};  // of rgb observations and of the sensors' images
  // Images of render_camera, which are for people.
  ImageSourceOptions render_options = {.renderer = "cpu", .shadows = false, .antialias = true};
};

// Options of a batch together with those that its task is made with. A Batch has its task already,
// so it refuses these; make() takes them.
struct MakeOptions : BatchOptions {
  // begin generated: task_fields
  // Constants of the task that differ from its own, by name: docs/variants.md.
  ConstantTable constants = {};
  // Control steps after which episodes are truncated, even if that is too early to succeed, instead
  // of the task's horizon. 0 (unset) to 1,000,000.
  int max_episode_steps = 0;
  // end generated
};

// Throw Error unless every number is within its range. Images are checked where they are made.
void check_ranges(const BatchOptions& options);
void check_ranges(const MakeOptions& options);

}  // namespace engram
