/** @file
 * engram: options of a batch, and of each task in it. A part of the C API; include engram_c.h. */
#ifndef ENGRAM_ENGRAM_OPTIONS_C_H
#define ENGRAM_ENGRAM_OPTIONS_C_H

/* NOLINTBEGIN(readability-identifier-naming,modernize-use-using,modernize-deprecated-headers):
 * this is C */

#include <stddef.h>
#include <stdint.h>

#include "engram_base_c.h"

#ifdef __cplusplus
extern "C" {
#endif

/* begin generated: obs_mode (tools/surface, from api/surface.toml) */
/** Contents of observations. */
typedef enum engram_obs_mode {
  ENGRAM_OBS_NONE = 0,
  /** One row of floats, in "observation". */
  ENGRAM_OBS_STATE = 1,
  /** One row; the description of the batch names its parts. */
  ENGRAM_OBS_STATE_DICT = 2,
  /** Images in "rgb" and "proprio"; "observation", which would reveal the hidden quantity, stays
   * empty. */
  ENGRAM_OBS_RGB = 3,
  /** One row of floats, in "observation": the robot, and what cameras can show of the objects;
   * nothing that is hidden. */
  ENGRAM_OBS_OBJECTS = 4,
  /** One row; the description of the batch names its parts. */
  ENGRAM_OBS_OBJECTS_DICT = 5,
  /** Rgb, and "depth": mm along the axis of the camera to what each pixel shows. */
  ENGRAM_OBS_RGB_DEPTH = 6,
  /** Rgb, and "segmentation": an index for each pixel; the description of the batch names the
   * values. */
  ENGRAM_OBS_RGB_SEGMENTATION = 7,
  /** Rgb, and both. */
  ENGRAM_OBS_RGB_DEPTH_SEGMENTATION = 8,
  /** Images, and the row of the state in "observation", for critics and teachers. */
  ENGRAM_OBS_RGB_STATE = 9,
  ENGRAM_OBS_RGB_DEPTH_STATE = 10,
  ENGRAM_OBS_RGB_SEGMENTATION_STATE = 11,
  ENGRAM_OBS_RGB_DEPTH_SEGMENTATION_STATE = 12,
  /** Images, and the row of objects in "observation". */
  ENGRAM_OBS_RGB_OBJECTS = 13,
  ENGRAM_OBS_RGB_DEPTH_OBJECTS = 14,
  ENGRAM_OBS_RGB_SEGMENTATION_OBJECTS = 15,
  ENGRAM_OBS_RGB_DEPTH_SEGMENTATION_OBJECTS = 16
} engram_obs_mode;
/* end generated */

/* begin generated: reward_mode */
typedef enum engram_reward_mode {
  ENGRAM_REWARD_NONE = 0,
  /** 1 in steps with success. */
  ENGRAM_REWARD_SPARSE = 1,
  /** The task's shaped reward. */
  ENGRAM_REWARD_DENSE = 2,
  /** The shaped reward, divided by its value at success. */
  ENGRAM_REWARD_NORMALIZED_DENSE = 3
} engram_reward_mode;
/* end generated */

/* begin generated: auto_reset */
/** Treatment of an environment whose episode has ended, in Gymnasium's terms. */
typedef enum engram_auto_reset {
  /** The next step ignores its action and returns the first observation of a new episode. */
  ENGRAM_AUTO_RESET_NEXT_STEP = 0,
  /** That step returns the first observation of a new episode; the last outputs of the episode are
   * kept as final outputs. */
  ENGRAM_AUTO_RESET_SAME_STEP = 1,
  /** It waits for a reset; the option after_end says what steps do meanwhile. */
  ENGRAM_AUTO_RESET_OFF = 2
} engram_auto_reset;
/* end generated */

/* begin generated: after_end */
/** Effect of a step on an environment whose episode has ended, where nothing resets it. */
typedef enum engram_after_end {
  /** It keeps its last outputs, with reward 0, until it is reset. */
  ENGRAM_AFTER_END_HOLD = 0,
  /** It is simulated on; success, reward and endings are reported as in any step. */
  ENGRAM_AFTER_END_CONTINUE = 1,
  /** Steps are refused until it is reset. */
  ENGRAM_AFTER_END_REFUSE = 2
} engram_after_end;
/* end generated */

/* begin generated: rules */
/** Rule set of a task, where the original's code differs from what it is meant to do. */
typedef enum engram_rules {
  /** Engram's own, which follow the benchmark's documentation. */
  ENGRAM_RULES_REFERENCE = 0,
  /** The original's code, as far as a task option can express it. */
  ENGRAM_RULES_ORIGINAL = 1
} engram_rules;
/* end generated */

/* begin generated: physics */
/** Engine that moves robot and props. */
typedef enum engram_physics {
  /** Engram's own, which follows the original's. */
  ENGRAM_PHYSICS_ENGRAM = 0,
  /** MuJoCo's own step, one mjData per environment. */
  ENGRAM_PHYSICS_MUJOCO = 1
} engram_physics;
/* end generated */

/** A sampled quantity of the episode, fixed by the user. */
typedef struct engram_pin {
  const char* name;     /**< a draw of engram_describe_json */
  const double* values; /**< `count` values, as many as the draw is wide */
  size_t count;
} engram_pin;

/** One of the task's own options. */
typedef struct engram_task_option {
  const char* name;
  double value;
} engram_task_option;

/** How far episodes depart from the task's usual scene, robot and words along an axis:
 * docs/variants.md. */
typedef struct engram_perturbation {
  const char* axis;
  double level; /**< 0 (none) to 1 */
} engram_perturbation;

typedef struct engram_options {
  size_t struct_size; /**< set by engram_options_init, and checked */
  /* begin generated: fields */
  /** Number of environments. 1 to 1,000,000; default 1. */
  int32_t num_envs;
  /** Threads that work on a step, the caller's included; results do not depend on it. 0 (one per
   * core) to 1024; default 0. */
  int32_t threads;
  /** Most environments that a thread claims at a time. 0 (chosen) or more; default 0. */
  int32_t chunk;
  /** Physics steps of 0.01 s per control step; 0 measures everything but physics. 0 to 1000;
   * default 5. */
  int32_t substeps;
  /** Environment i has seed + i. Default 0. */
  uint64_t seed;
  /** Contents of observations. An engram_obs_mode; default ENGRAM_OBS_STATE. */
  int32_t obs_mode;
  /** The reward of a step. An engram_reward_mode; default ENGRAM_REWARD_NORMALIZED_DENSE. */
  int32_t reward_mode;
  /** Treatment of an environment whose episode has ended. An engram_auto_reset; default
   * ENGRAM_AUTO_RESET_NEXT_STEP. */
  int32_t auto_reset;
  /** Meaning of actions. Default NULL: the task's own. */
  const char* control_mode;
  /** Sign of rotation actions; -1 as the original benchmark has it. -1 or 1; default -1. */
  int32_t rotation_sign;
  /** Actions are replaced by zeros during cue and empty phase, where the canonical wrapper chain
   * does so. Default 1. */
  int32_t freeze_cue;
  /** End of episodes at success, whatever the task's own rule. -1 (the task's own rule), 0 or 1;
   * default -1. */
  int32_t terminate_on_success;
  /** Shortcuts of the physics; off: none of them, for comparison. Default 1. */
  int32_t sleep;
  /** Standard deviation of the arm joints' noise in the start pose. 0 to 1 rad; default 0.02. */
  double robot_init_qpos_noise;
  /** Objects modes: elapsed time in observations, as a share of the horizon. Default 0. */
  int32_t observe_time;
  /** Proprio has the arm's seven joint angles and the gripper's opening, instead of the TCP's pose
   * and the opening. Default 0. */
  int32_t joint_proprio;
  /** Environments whose robots move side by side in vector registers: 1, 4, 8 or 16; results are
   * the same. 0, 1, 4, 8 or 16; default 0. */
  int32_t lanes;
  /** Quantities of every episode that are fixed instead of drawn. Default none. */
  const engram_pin* pins; /**< num_pins of them */
  size_t num_pins;
  /** Variants of the task's rules, by name. Default none. */
  const engram_task_option* task_options; /**< num_task_options of them */
  size_t num_task_options;
  /** Constants of the task that differ from its own, by name: docs/variants.md. Default none. */
  const char* constants; /**< a JSON object: {"COLORS": 7, "CUE_PHASE_STEPS": [3, 5]}; NULL: none */
  /** Rule set of the task: the default of every task option; task_options win. An engram_rules;
   * default ENGRAM_RULES_REFERENCE. */
  int32_t rules;
  /** Width of rgb observations. 1 to 4096 pixels; default 128. */
  int32_t image_width;
  /** Height of rgb observations. 1 to 4096 pixels; default 128. */
  int32_t image_height;
  /** Cameras of rgb observations, in channel order. Default base_camera, hand_camera. */
  const char* const* cameras; /**< num_cameras names; NULL: the default */
  size_t num_cameras;
  /** Renderer of rgb observations. "cpu" or "egl"; default "cpu". */
  const char* renderer;
  /** Shadows in rgb observations. Default 0. */
  int32_t shadows;
  /** 2 x 2 samples per pixel in rgb observations. Default 0. */
  int32_t antialias;
  /** Soft shadows in images of render_camera; the original benchmark has none. Default 0. */
  int32_t render_shadows;
  /** End of episodes at failure, where the task's rule has it; off, with terminate_on_success off
   * as well: at the horizon only. Default 1. */
  int32_t terminate_on_failure;
  /** Auto-reset off: effect of a step on an environment whose episode has ended. An
   * engram_after_end; default ENGRAM_AFTER_END_HOLD. */
  int32_t after_end;
  /** Control steps after which episodes are truncated, even if that is too early to succeed,
   * instead of the task's horizon. 0 (unset) to 1,000,000; default 0. */
  int32_t max_episode_steps;
  /** Departures from the task's usual scene, robot and words, by axis, from 0 (none) to 1:
   * docs/variants.md. Default none. */
  const engram_perturbation* perturbations; /**< num_perturbations of them */
  size_t num_perturbations;
  /** Engine that moves robot and props. An engram_physics; default ENGRAM_PHYSICS_ENGRAM. */
  int32_t physics;
  /* end generated */
} engram_options;

/** Sets every field to its default. */
ENGRAM_API void engram_options_init(engram_options* options);

/** Environments of one task in a batch of several, and what is the task's own; what options have
 * for all tasks comes in addition, and loses where both name the same. */
typedef struct engram_task_share {
  const char* id;
  int32_t num_envs;       /**< 1 or more */
  const char* constants;  /**< a JSON object as in engram_options; NULL: none */
  const engram_pin* pins; /**< num_pins of them */
  size_t num_pins;
  const engram_task_option* task_options; /**< num_task_options of them */
  size_t num_task_options;
} engram_task_share;

#ifdef __cplusplus
}
#endif

/* NOLINTEND(readability-identifier-naming,modernize-use-using,modernize-deprecated-headers) */

#endif
