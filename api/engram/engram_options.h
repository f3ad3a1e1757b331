/// @file
/// engram: options of a batch, and of each task in it. A part of the C++ API; include engram.h.
#ifndef ENGRAM_ENGRAM_OPTIONS_H
#define ENGRAM_ENGRAM_OPTIONS_H

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "engram/engram_c.h"

namespace engram {
inline namespace v0 {

// begin generated: enums (tools/surface, from api/surface.toml)
/// Contents of observations.
enum class ObsMode {
  kNone = ENGRAM_OBS_NONE,
  /// One row of floats, in "observation".
  kState = ENGRAM_OBS_STATE,
  /// One row; the description of the batch names its parts.
  kStateDict = ENGRAM_OBS_STATE_DICT,
  /// Images in "rgb" and "proprio"; "observation", which would reveal the hidden quantity, stays
  /// empty.
  kRgb = ENGRAM_OBS_RGB,
  /// One row of floats, in "observation": the robot, and what cameras can show of the objects;
  /// nothing that is hidden.
  kObjects = ENGRAM_OBS_OBJECTS,
  /// One row; the description of the batch names its parts.
  kObjectsDict = ENGRAM_OBS_OBJECTS_DICT,
  /// Rgb, and "depth": mm along the axis of the camera to what each pixel shows.
  kRgbDepth = ENGRAM_OBS_RGB_DEPTH,
  /// Rgb, and "segmentation": an index for each pixel; the description of the batch names the
  /// values.
  kRgbSegmentation = ENGRAM_OBS_RGB_SEGMENTATION,
  /// Rgb, and both.
  kRgbDepthSegmentation = ENGRAM_OBS_RGB_DEPTH_SEGMENTATION,
  /// Images, and the row of the state in "observation", for critics and teachers.
  kRgbState = ENGRAM_OBS_RGB_STATE,
  kRgbDepthState = ENGRAM_OBS_RGB_DEPTH_STATE,
  kRgbSegmentationState = ENGRAM_OBS_RGB_SEGMENTATION_STATE,
  kRgbDepthSegmentationState = ENGRAM_OBS_RGB_DEPTH_SEGMENTATION_STATE,
  /// Images, and the row of objects in "observation".
  kRgbObjects = ENGRAM_OBS_RGB_OBJECTS,
  kRgbDepthObjects = ENGRAM_OBS_RGB_DEPTH_OBJECTS,
  kRgbSegmentationObjects = ENGRAM_OBS_RGB_SEGMENTATION_OBJECTS,
  kRgbDepthSegmentationObjects = ENGRAM_OBS_RGB_DEPTH_SEGMENTATION_OBJECTS,
};

enum class RewardMode {
  kNone = ENGRAM_REWARD_NONE,
  /// 1 in steps with success.
  kSparse = ENGRAM_REWARD_SPARSE,
  /// The task's shaped reward.
  kDense = ENGRAM_REWARD_DENSE,
  /// The shaped reward, divided by its value at success.
  kNormalizedDense = ENGRAM_REWARD_NORMALIZED_DENSE,
};

/// Treatment of an environment whose episode has ended, in Gymnasium's terms.
enum class AutoReset {
  /// The next step ignores its action and returns the first observation of a new episode.
  kNextStep = ENGRAM_AUTO_RESET_NEXT_STEP,
  /// That step returns the first observation of a new episode; the last outputs of the episode are
  /// kept as final outputs.
  kSameStep = ENGRAM_AUTO_RESET_SAME_STEP,
  /// It waits for a reset; the option after_end says what steps do meanwhile.
  kOff = ENGRAM_AUTO_RESET_OFF,
};

/// Effect of a step on an environment whose episode has ended, where nothing resets it.
enum class AfterEnd {
  /// It keeps its last outputs, with reward 0, until it is reset.
  kHold = ENGRAM_AFTER_END_HOLD,
  /// It is simulated on; success, reward and endings are reported as in any step.
  kContinue = ENGRAM_AFTER_END_CONTINUE,
  /// Steps are refused until it is reset.
  kRefuse = ENGRAM_AFTER_END_REFUSE,
};

/// Source of the actions that the batch itself chooses.
enum class Policy {
  kZero = ENGRAM_POLICY_ZERO,
  /// Uniform over the action space.
  kRandom = ENGRAM_POLICY_RANDOM,
  /// Solves the task with privileged state; pd_ee_delta_pose, pd_joint_pos and pd_joint_delta_pos
  /// only.
  kOracle = ENGRAM_POLICY_ORACLE,
  /// The oracle, but with the hidden quantity guessed.
  kBlind = ENGRAM_POLICY_BLIND,
  /// The best that can be done without memory.
  kSweep = ENGRAM_POLICY_SWEEP,
};

/// Rule set of a task, where the original's code differs from what it is meant to do.
enum class Rules {
  /// Engram's own, which follow the benchmark's documentation.
  kReference = ENGRAM_RULES_REFERENCE,
  /// The original's code, as far as a task option can express it.
  kOriginal = ENGRAM_RULES_ORIGINAL,
};

/// Engine that moves robot and props.
enum class Physics {
  kEngram = ENGRAM_PHYSICS_ENGRAM,  ///< engram's own, which follows the original's
  kMujoco = ENGRAM_PHYSICS_MUJOCO,  ///< MuJoCo's own step, one mjData per environment
};

/// Meaning of actions; in brackets their dimension.
enum class ControlMode {
  kPdJointDeltaPos,        ///< (8)
  kPdJointPos,             ///< (8) not normalised
  kPdEeDeltaPos,           ///< (4)
  kPdEeDeltaPose,          ///< (7) canonical
  kPdEePose,               ///< (7) unbounded, not normalised
  kPdJointTargetDeltaPos,  ///< (8)
  kPdEeTargetDeltaPos,     ///< (4)
  kPdEeTargetDeltaPose,    ///< (7)
  kPdJointVel,             ///< (8)
  kPdJointPosVel,          ///< (15) not normalised
  kPdJointDeltaPosVel,     ///< (15)
};
// end generated

/// A sampled quantity of the episode, fixed: describe() lists the draws with widths and ranges.
struct Pin {
  std::string name;
  std::vector<double> values;
};

/// A choice between variants of the task's rules: describe() lists the options and their ranges.
struct TaskOption {
  std::string name;
  double value = 0;
};

/// How far episodes depart from the task's usual scene, robot and words along an axis:
/// docs/variants.md.
struct Perturbation {
  std::string axis;
  double level = 0;  ///< 0 (none) to 1
};

/// Options of rgb observations.
struct ImageOptions {
  // begin generated: images
  /// Width of rgb observations. 1 to 4096 pixels.
  int width = 128;
  /// Height of rgb observations. 1 to 4096 pixels.
  int height = 128;
  /// Cameras of rgb observations, in channel order.
  std::vector<std::string> cameras = {"base_camera", "hand_camera"};
  /// Renderer of rgb observations. "cpu" or "egl".
  std::string renderer = "cpu";
  /// Shadows in rgb observations.
  bool shadows = false;
  /// 2 x 2 samples per pixel in rgb observations.
  bool antialias = false;
  // end generated
};

struct EnvOptions {
  // begin generated: fields
  /// Number of environments. 1 to 1,000,000.
  int num_envs = 1;
  /// Environment i has seed + i.
  std::uint64_t seed = 0;
  /// Threads that work on a step, the caller's included; results do not depend on it. 0 (one per
  /// core) to 1024.
  int threads = 0;
  /// Most environments that a thread claims at a time. 0 (chosen) or more.
  int chunk = 0;
  /// Contents of observations.
  ObsMode obs_mode = ObsMode::kState;
  /// Objects modes: elapsed time in observations, as a share of the horizon.
  bool observe_time = false;
  /// Proprio has the arm's seven joint angles and the gripper's opening, instead of the TCP's pose
  /// and the opening.
  bool joint_proprio = false;
  /// The reward of a step.
  RewardMode reward_mode = RewardMode::kNormalizedDense;
  /// Meaning of actions.
  std::optional<ControlMode> control_mode = std::nullopt;
  /// Treatment of an environment whose episode has ended.
  AutoReset auto_reset = AutoReset::kNextStep;
  /// Sign of rotation actions; -1 as the original benchmark has it. -1 or 1.
  int rotation_sign = -1;
  /// Actions are replaced by zeros during cue and empty phase, where the canonical wrapper chain
  /// does so.
  bool freeze_cue = true;
  /// End of episodes at success, whatever the task's own rule.
  std::optional<bool> terminate_on_success = std::nullopt;
  /// Standard deviation of the arm joints' noise in the start pose. 0 to 1 rad.
  double robot_init_qpos_noise = 0.02;
  /// Shortcuts of the physics; off: none of them, for comparison.
  bool sleep = true;
  /// Environments whose robots move side by side in vector registers: 1, 4, 8 or 16; results are
  /// the same. 0, 1, 4, 8 or 16.
  int lanes = 0;
  /// Physics steps of 0.01 s per control step; 0 measures everything but physics. 0 to 1000.
  int substeps = 5;
  /// Quantities of every episode that are fixed instead of drawn.
  std::vector<Pin> pins = {};
  /// Variants of the task's rules, by name.
  std::vector<TaskOption> task_options = {};
  /// Constants of the task that differ from its own, by name: docs/variants.md.
  std::string constants = {};
  /// Rule set of the task: the default of every task option; task_options win.
  Rules rules = Rules::kReference;
  /// Soft shadows in images of render_camera; the original benchmark has none.
  bool render_shadows = false;
  /// End of episodes at failure, where the task's rule has it; off, with terminate_on_success off
  /// as well: at the horizon only.
  bool terminate_on_failure = true;
  /// Auto-reset off: effect of a step on an environment whose episode has ended.
  AfterEnd after_end = AfterEnd::kHold;
  /// Control steps after which episodes are truncated, even if that is too early to succeed,
  /// instead of the task's horizon. 0 (unset) to 1,000,000.
  int max_episode_steps = 0;
  /// Departures from the task's usual scene, robot and words, by axis, from 0 (none) to 1:
  /// docs/variants.md.
  std::vector<Perturbation> perturbations = {};
  /// Engine that moves robot and props.
  Physics physics = Physics::kEngram;
  // end generated
  ImageOptions images = {};
};

/// Environments of one task in a batch of several, and what is the task's own: it comes in addition
/// to what the options have for all tasks, and wins.
struct TaskShare {
  std::string id;
  int num_envs = 1;
  std::string constants = {};  ///< a JSON object as in EnvOptions; empty: none
  std::vector<Pin> pins = {};
  std::vector<TaskOption> task_options = {};
};

}  // namespace v0
}  // namespace engram

#endif
