/** @file
 * engram: batched memory-manipulation tasks on CPUs. The plain C API.
 *
 *     engram_options options;
 *     engram_options_init(&options);
 *     options.num_envs = 256;
 *     engram_env* env = NULL;
 *     if (engram_make("RememberColor9-VLA-v0", &options, &env) != ENGRAM_OK)
 *       puts(engram_last_error());
 *     engram_reset(env, NULL);
 *     engram_step(env, actions, 256 * engram_action_dim(env));
 *     engram_close(env);
 *
 * Functions that can fail return an engram_status; a failing call changes nothing and leaves a
 * one-line message, which says what was wrong, what was given and what is allowed, in
 * engram_last_error. No function throws, prints or exits. N stands for the number of environments.
 *
 * A handle may be used from any thread, but from one at a time: a call that comes while another
 * one is at work on the same handle, or between engram_step_async and engram_step_wait, is refused
 * with ENGRAM_BAD_STATE. So is a call in a process that was forked after engram_make, where the
 * batch's threads are not; engram_close does nothing there. Numbers that never change
 * (engram_num_envs and the like, which take a const handle) can be asked for at any time. A NULL
 * where an address is needed is refused with ENGRAM_INVALID_ARGUMENT. After engram_close a handle
 * must not be used any more. */
#ifndef ENGRAM_ENGRAM_C_H
#define ENGRAM_ENGRAM_C_H

/* NOLINTBEGIN(readability-identifier-naming,modernize-use-using,modernize-deprecated-headers):
 * this is C */

#include <stddef.h>
#include <stdint.h>

#if defined(ENGRAM_STATIC)
#define ENGRAM_API
#else
#define ENGRAM_API __attribute__((visibility("default")))
#endif

#ifdef __cplusplus
extern "C" {
#endif

typedef enum engram_status {
  ENGRAM_OK = 0,
  ENGRAM_INVALID_ARGUMENT = 1, /**< a value outside what is allowed, or of the wrong shape */
  ENGRAM_UNKNOWN_ID = 2,       /**< no task, option or field of that name */
  ENGRAM_UNAVAILABLE = 3,      /**< the machine lacks it: threads, memory, a device */
  ENGRAM_BAD_STATE = 4,        /**< not allowed at this point */
  ENGRAM_IO = 5,               /**< a file could not be read or written */
  ENGRAM_INTERNAL = 6,         /**< a defect of the library itself */
  ENGRAM_TASK_FAILED = 7       /**< the code of a user's task has failed */
} engram_status;

/** The message of this thread's last failing call; "" if there was none. Valid until this thread's
 * next failing call. Never NULL. */
ENGRAM_API const char* engram_last_error(void);

/** Version of the library, "0.5.0". */
ENGRAM_API const char* engram_version(void);

/* ---- tasks ---- */

/** Ids of all registered tasks: the benchmark's, in its order, then variants, in the order in which
 * they were registered. Libraries of tasks that the environment variable ENGRAM_TASKS names,
 * separated by ':' (Python files among them are skipped), are loaded, and variants out of the file
 * that ENGRAM_VARIANTS names are registered, by the first call that looks for ids; while such a
 * file is refused, so are these calls. */
ENGRAM_API size_t engram_num_tasks(void);
/** index: 0 to engram_num_tasks() - 1; NULL beyond. Valid for the life of the process. */
ENGRAM_API const char* engram_task_id(size_t index);

/** All registered tasks as a JSON array, in that order: what `engram list --json` prints. Valid for
 * the life of the process. NULL, with a message, if there is no memory for it. */
ENGRAM_API const char* engram_list_json(void);

/** Registers a new id ("RememberColor7-Slow-v0") for a task ("RememberColor9-VLA-v0") with other
 * constants, for the life of the process. constants: a JSON object as in engram_options; NULL:
 * none. instruction: NULL: that of the base. The same variant twice is one. Fails with
 * ENGRAM_UNKNOWN_ID if there is no such base or constant, ENGRAM_INVALID_ARGUMENT if the id is
 * taken or not of the form name-vN, or the task cannot be made with these constants. */
ENGRAM_API engram_status engram_register_variant(const char* id, const char* base,
                                                 const char* constants, const char* instruction);
/** Registers all variants of a file (docs/variants.md), or none. Fails also with ENGRAM_IO if it
 * cannot be read. */
ENGRAM_API engram_status engram_load_variants(const char* path);
/** Loads a library of tasks (docs/adding_a_task.md) for the life of the process; the same library
 * twice is one. Its code runs with all rights of the process. Fails with ENGRAM_IO if the file
 * cannot be read, ENGRAM_INVALID_ARGUMENT if it is no such library, was made for another version
 * of engram or with another ABI, or one of its ids is taken. */
ENGRAM_API engram_status engram_load_tasks(const char* path);

/* ---- options ---- */

/* begin options: obs_mode (scripts/options.py writes what stands between these marks) */
/** Contents of observations. */
typedef enum engram_obs_mode {
  ENGRAM_OBS_NONE = 0,
  /** One row of floats, in "observation". */
  ENGRAM_OBS_STATE = 1,
  /** The same row; the description of the batch names its parts. */
  ENGRAM_OBS_STATE_DICT = 2,
  /** Images in "rgb" and "proprio"; "observation", which would reveal the hidden quantity, stays
   * empty. */
  ENGRAM_OBS_RGB = 3,
  /** One row of floats, in "observation": the robot, and what cameras can show of the objects;
   * nothing that is hidden. */
  ENGRAM_OBS_OBJECTS = 4,
  /** The same row; the description of the batch names its parts. */
  ENGRAM_OBS_OBJECTS_DICT = 5,
  /** Rgb, and "depth": mm along the axis of the camera to what each pixel shows. */
  ENGRAM_OBS_RGB_DEPTH = 6,
  /** Rgb, and "segmentation": an index for each pixel; the description of the batch names the
   * values. */
  ENGRAM_OBS_RGB_SEGMENTATION = 7,
  /** Rgb, and both. */
  ENGRAM_OBS_RGB_DEPTH_SEGMENTATION = 8
} engram_obs_mode;
/* end options */

/* begin options: reward_mode */
typedef enum engram_reward_mode {
  ENGRAM_REWARD_NONE = 0,
  /** 1 in steps with success. */
  ENGRAM_REWARD_SPARSE = 1,
  /** The task's shaped reward. */
  ENGRAM_REWARD_DENSE = 2,
  /** The same, divided by its value at success. */
  ENGRAM_REWARD_NORMALIZED_DENSE = 3
} engram_reward_mode;
/* end options */

/* begin options: auto_reset */
/** Treatment of an environment whose episode has ended, in Gymnasium's terms. */
typedef enum engram_auto_reset {
  /** The next step ignores its action and returns the first observation of a new episode. */
  ENGRAM_AUTO_RESET_NEXT_STEP = 0,
  /** The same step returns it; the last outputs of the episode are kept as final outputs. */
  ENGRAM_AUTO_RESET_SAME_STEP = 1,
  /** It waits for a reset; the option after_end says what steps do meanwhile. */
  ENGRAM_AUTO_RESET_OFF = 2
} engram_auto_reset;
/* end options */

/* begin options: after_end */
/** Effect of a step on an environment whose episode has ended, where nothing resets it. */
typedef enum engram_after_end {
  /** It keeps its last outputs, with reward 0, until it is reset. */
  ENGRAM_AFTER_END_HOLD = 0,
  /** It is simulated on; success, reward and endings are reported as in any step. */
  ENGRAM_AFTER_END_CONTINUE = 1,
  /** Steps are refused until it is reset. */
  ENGRAM_AFTER_END_REFUSE = 2
} engram_after_end;
/* end options */

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
 * docs/perturbations.md. */
typedef struct engram_perturbation {
  const char* axis;
  double level; /**< 0 (none) to 1 */
} engram_perturbation;

typedef struct engram_options {
  size_t struct_size; /**< set by engram_options_init, and checked */
  /* begin options: fields */
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
  /** Environments whose robots move side by side in vector registers: 1, 2, 4 or 8; results are the
   * same. 0, 1, 2, 4 or 8; default 0. */
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
  /** Soft shadows in pictures of render_camera; the original benchmark has none. Default 0. */
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
   * docs/perturbations.md. Default none. */
  const engram_perturbation* perturbations; /**< num_perturbations of them */
  size_t num_perturbations;
  /* end options */
} engram_options;

/** Sets every field to its default. */
ENGRAM_API void engram_options_init(engram_options* options);

/* ---- life of a batch ---- */

typedef struct engram_env engram_env;

/** Makes a batch of the task with that id. options: NULL for the defaults, else initialised by
 * engram_options_init; nothing in it is used after the call. Fails with ENGRAM_UNKNOWN_ID (the
 * message names the nearest id), ENGRAM_INVALID_ARGUMENT or ENGRAM_UNAVAILABLE, and then *env is
 * NULL. */
ENGRAM_API engram_status engram_make(const char* id, const engram_options* options,
                                     engram_env** env);

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

/** Makes one batch of several tasks, stepped in lockstep. The environments of the first task come
 * first; environment i of a task has options.seed + i, and is bit for bit what it is alone.
 * options.num_envs does not count. Outputs have one array each over all environments, as wide as
 * the widest task's, zero where a task lacks them, float32 where tasks differ in type; fields of
 * observation rows have one place in the rows of all tasks. Two more outputs: task_index (N), and
 * in the objects modes object_mask (N, objects), 1 where the task has that object. "tasks" of
 * engram_describe_json lists the tasks. Fails as engram_make does. */
ENGRAM_API engram_status engram_make_group(const engram_task_share* tasks, size_t num_tasks,
                                           const engram_options* options, engram_env** env);

/** Ends the batch and frees what it owns; a call or step under way is waited for. NULL is allowed.
 */
ENGRAM_API void engram_close(engram_env* env);

/* ---- facts about a batch ---- */

ENGRAM_API int32_t engram_num_envs(const engram_env* env);
ENGRAM_API int32_t engram_num_threads(const engram_env* env);
ENGRAM_API int32_t engram_action_dim(const engram_env* env);
ENGRAM_API int32_t engram_state_dim(const engram_env* env);
/** Control steps of an episode; of several tasks the longest. */
ENGRAM_API int32_t engram_horizon(const engram_env* env);
/** Least and greatest value of each action component, engram_action_dim of them; infinite where
 * there is no bound. */
ENGRAM_API const float* engram_action_low(const engram_env* env);
ENGRAM_API const float* engram_action_high(const engram_env* env);
/** The task in full as JSON: what `engram info ID --json` prints, for this batch's options. Valid
 * for the life of the handle. NULL, with a message, if there is no memory for it or the handle is
 * in use. */
ENGRAM_API const char* engram_describe_json(engram_env* env);
/** The same without a handle: *description is that of a batch that engram_make would make, to be
 * freed by engram_free_text; NULL if the call fails, as engram_make would. num_envs and threads
 * change nothing. */
ENGRAM_API engram_status engram_describe_task_json(const char* id, const engram_options* options,
                                                   char** description);
/** Environment steps in which physics diverged, since the batch was made. */
ENGRAM_API uint64_t engram_unstable_count(const engram_env* env);

/* ---- running it ---- */

typedef struct engram_reset_request {
  const uint8_t* mask; /**< N values, non-zero: reset; NULL: all */
  const uint64_t*
      seeds; /**< N values, those of masked-out environments are ignored; NULL: the first
                reset uses options.seed + i, later ones go on to the next episode */
  const engram_pin* pins; /**< replaces the pins of the environments that are reset if has_pins */
  size_t num_pins;
  int32_t has_pins; /**< 0: pins stay as they are */
  /** Replaces the narrower ranges of the environments that are reset: a JSON object of constants
   * that are ranges, each within that of the batch, {"EMPTY_PHASE_STEPS": [1, 3]}; pins still win.
   * NULL: ranges stay as they are. */
  const char* constants;
} engram_reset_request;

/** Starts new episodes. request: NULL for all environments, seeds and pins as before. */
ENGRAM_API engram_status engram_reset(engram_env* env, const engram_reset_request* request);

/** One control step. actions: (N, action_dim) floats, row by row; count: N * action_dim. Refused if
 * the count is wrong, a value is not finite or nothing was reset. */
ENGRAM_API engram_status engram_step(engram_env* env, const float* actions, size_t count);

/** One control step without a new command: the drives keep their targets, at first those of the
 * start pose. Refused if nothing was reset. */
ENGRAM_API engram_status engram_step_no_action(engram_env* env);

/** engram_step in two halves: the first checks and copies the actions, hands the step to a thread
 * of the batch's own and returns; the second waits for it. In between the batch's outputs change
 * and must not be read, and other calls on the handle are refused. */
ENGRAM_API engram_status engram_step_async(engram_env* env, const float* actions, size_t count);
/** Refused with ENGRAM_BAD_STATE if no step is under way. */
ENGRAM_API engram_status engram_step_wait(engram_env* env);
/** The same, after `seconds` (0 or more) at most: *done is 1 if the step is done, 0 if it goes on
 * and has to be waited for again. */
ENGRAM_API engram_status engram_step_wait_for(engram_env* env, double seconds, int32_t* done);

/* begin options: rules */
/** Rule set of a task, where the original's code differs from what it is meant to do. */
typedef enum engram_rules {
  /** Engram's own, which follow the benchmark's documentation. */
  ENGRAM_RULES_REFERENCE = 0,
  /** The original's code, as far as a task option can express it. */
  ENGRAM_RULES_ORIGINAL = 1
} engram_rules;
/* end options */

/* begin options: policy */
/** Source of the actions that the batch itself chooses. */
typedef enum engram_policy {
  ENGRAM_POLICY_ZERO = 0,
  /** Uniform over the action space. */
  ENGRAM_POLICY_RANDOM = 1,
  /** Solves the task with privileged state; pd_ee_delta_pose, pd_joint_pos and pd_joint_delta_pos
   * only. */
  ENGRAM_POLICY_ORACLE = 2,
  /** The oracle, but with the hidden quantity guessed. */
  ENGRAM_POLICY_BLIND = 3,
  /** The best that can be done without memory. */
  ENGRAM_POLICY_SWEEP = 4
} engram_policy;
/* end options */

/** Writes actions for the next step, (N, action_dim) floats; count: N * action_dim. */
ENGRAM_API engram_status engram_act(engram_env* env, int32_t policy, float* actions, size_t count);

/* ---- outputs ---- */

typedef enum engram_dtype {
  ENGRAM_BOOL = 0, /**< one byte, 0 or 1 */
  ENGRAM_INT32 = 1,
  ENGRAM_UINT64 = 2,
  ENGRAM_FLOAT32 = 3,
  ENGRAM_FLOAT64 = 4,
  ENGRAM_UINT8 = 5,
  ENGRAM_INT16 = 6
} engram_dtype;

/** An array of the batch, row by row without gaps. */
typedef struct engram_array {
  const char* name;
  const char* unit;        /**< "m", "rad", "" where the values have none */
  const char* description; /**< one phrase, or "" */
  const void* data; /**< stays where it is for the life of the handle; changes with each step */
  int32_t dtype;    /**< engram_dtype */
  int32_t ndim;
  int64_t shape[4]; /**< the first `ndim` count; the first of them is N */
} engram_array;

/** An output by name: observation (N, state_dim; N, 0 where obs_mode is none or rgb), rgb (N,
 * height, width, 3 * cameras; rgb modes only), depth and segmentation (N, height, width, cameras;
 * int16; in the modes that have them: millimetres along the camera's axis, 32767 at most, 0 where
 * nothing is; and what is seen, an index into "segmentation_names" of engram_describe_json),
 * proprio (N, 7), reward, terminated, truncated, success, failed, unstable, elapsed_steps,
 * success_once, episode_return, final_mask, and the task's own info fields. Fields of width 1 have
 * shape (N). */
ENGRAM_API engram_status engram_output(engram_env* env, const char* name, engram_array* array);
/** The same at the end of the episode that ended last in each environment; the output "final_mask"
 * (N) is 1 for the environments where that was in this step. All but final_mask are kept. Refused
 * with ENGRAM_BAD_STATE unless auto_reset is same-step. */
ENGRAM_API engram_status engram_final_output(engram_env* env, const char* name,
                                             engram_array* array);
/** Outputs by number, 0 to engram_num_outputs - 1. */
ENGRAM_API size_t engram_num_outputs(const engram_env* env);
ENGRAM_API engram_status engram_output_at(engram_env* env, size_t index, engram_array* array);

/** An array of the caller's for an output. */
typedef struct engram_output_target {
  const char* name;
  void* data;
  size_t size; /**< bytes: exactly those of the output */
} engram_output_target;

/** From the first reset on, outputs are written to arrays of the caller's, `count` of them; they
 * outlive the handle. Arrays of pictures that engram_output returned before are no longer valid:
 * pictures are drawn into the caller's alone, to which it then points. second: NULL, or as many
 * arrays for the same outputs: steps then write to the second and the first in turns, so that one
 * can be read while a step_async writes the other. Refused after the first reset, and for a name or
 * size that is wrong. */
ENGRAM_API engram_status engram_write_outputs(engram_env* env, const engram_output_target* first,
                                              const engram_output_target* second, size_t count);
/** 0 or 1: the arrays, first or second, that the last reset or step has written to. */
ENGRAM_API int32_t engram_output_turn(const engram_env* env);

/** The language instruction of one environment's episode. Copies at most `capacity` bytes, the
 * closing 0 included, and sets *length (may be NULL) to the length without it. */
ENGRAM_API engram_status engram_instruction(engram_env* env, int32_t index, char* text,
                                            size_t capacity, size_t* length);

/** One environment's episode in words, as JSON: plan (the subtasks), subtask (index of the present
 * one), subtasks_done, memory (what has been shown and has to be remembered), object (that is
 * meant, or null), and paraphrases of the instruction. Privileged, but for these: not for policies.
 * Copies as engram_instruction does. */
ENGRAM_API engram_status engram_words(engram_env* env, int32_t index, char* text, size_t capacity,
                                      size_t* length);

/** Questions (docs/choices.md) while an episode runs: somebody names the answer, and
 * ENGRAM_POLICY_BLIND of engram_act carries it out. engram_ask: from now on that policy waits in
 * one environment's episode until the question is answered, instead of guessing; to be called after
 * each reset. Refused for tasks without choices ("choices" of engram_describe_json is null). */
ENGRAM_API engram_status engram_ask(engram_env* env, int32_t index);
/** The question as JSON: due (the policy cannot go on without an answer), question, choices (in an
 * order that means nothing), least and most (of an answer), repeats (one may be named twice).
 * Copies as engram_instruction does. */
ENGRAM_API engram_status engram_question(engram_env* env, int32_t index, char* text,
                                         size_t capacity, size_t* length);
/** Answers the question by `count` indices of its choices, in order. Refused with ENGRAM_BAD_STATE
 * if none is due. */
ENGRAM_API engram_status engram_answer(engram_env* env, int32_t index, const int32_t* choices,
                                       size_t count);

/** Draws one environment as it is now, row 0 on top. camera: one of the scene's
 * (docs/cameras.md); sides 1 to 4096 pixels; rgb: size = height * width * 3 bytes. */
ENGRAM_API engram_status engram_render(engram_env* env, int32_t index, const char* camera,
                                       int32_t width, int32_t height, uint8_t* rgb, size_t size);

/* ---- queries: no part of observations ---- */

/** The robot in all environments, in every observation mode: qpos (N, 9) and qvel (N, 9), arm
 * joints and fingers, rad and m; tcp_pose (N, 7), position in m and quaternion (w, x, y, z) in the
 * world. NULL: not wanted. Refused with ENGRAM_BAD_STATE before the first reset. */
ENGRAM_API engram_status engram_robot_state(engram_env* env, float* qpos, float* qvel,
                                            float* tcp_pose);
/** A camera of the scene in all environments, for pictures of that size: extrinsic_cv (N, 3, 4),
 * from the world to the camera (x right, y down, z forward); cam2world_gl (N, 4, 4), from the
 * camera (x right, y up, z backward) to the world; intrinsic_cv (N, 3, 3), in pixels, where pixel
 * (0, 0) covers 0 to 1. NULL: not wanted. */
ENGRAM_API engram_status engram_camera_params(engram_env* env, const char* camera, int32_t width,
                                              int32_t height, float* extrinsic_cv,
                                              float* cam2world_gl, float* intrinsic_cv);
/** Values that an episode has drawn, such as the lengths of its phases: how many of them there are
 * (0 in a batch of several tasks; "drawn" of engram_describe_json names them, in order), and those
 * of all environments, row by row; count: N * engram_drawn_dim. They reveal what policies must not
 * know. */
ENGRAM_API int32_t engram_drawn_dim(const engram_env* env);
ENGRAM_API engram_status engram_drawn(engram_env* env, float* values, size_t count);

/* ---- snapshots ---- */

#define ENGRAM_WHOLE_BATCH (-1) /**< instead of the index of an environment */

/** Saves environment `index`, or ENGRAM_WHOLE_BATCH, bit-exactly. Sets *size to the number of bytes
 * and copies them if `capacity` is as many; a capacity of 0 only asks for the size (bytes may then
 * be NULL), any other that is too small is refused. The size is the same for the life of the
 * handle. */
ENGRAM_API engram_status engram_save(engram_env* env, int32_t index, void* bytes, size_t capacity,
                                     size_t* size);
/** Restores into environment `index` (which has been reset before) of any batch of the same task,
 * control mode and task options, or ENGRAM_WHOLE_BATCH into a batch of the same size. How it goes
 * on and what is observed is up to the other options of that batch. Refused if the bytes are
 * damaged or of another task, version or number of environments. */
ENGRAM_API engram_status engram_restore(engram_env* env, int32_t index, const void* bytes,
                                        size_t size);

/* ---- evaluation ---- */

/** Episodes that need actions, one row each in every array. Valid during the call alone. */
typedef struct engram_policy_request {
  size_t struct_size;
  const char* env_id;
  int32_t count;        /**< rows */
  int32_t worker;       /**< the thread's batch: 0 to threads - 1 */
  const int32_t* slots; /**< place among the worker's episodes, 0 to max_slots - 1: the same from an
                           episode's first request to its last */
  const int32_t* episodes; /**< opaque numbers, the same in every run; with tell_episodes 0 to the
                              number of episodes - 1 */
  const int32_t* steps;    /**< control steps taken so far */
  const uint8_t* first;    /**< 1: the episode's first request */
  const char* const* instructions;
  const float* proprio; /**< (count, proprio_dim) */
  const uint8_t* rgb;   /**< (count, height, width, 6), or NULL without images */
  const float* state;   /**< (count, state_dim): state or objects, or NULL with images */
  int32_t height;
  int32_t width;
  int32_t state_dim;
  int32_t max_slots;
  int32_t action_dim;
  const uint64_t* seeds; /**< of the episodes, with tell_episodes; otherwise NULL */
  uint64_t policy_seed;  /**< of the policy's own random numbers */
  int32_t proprio_dim;
} engram_policy_request;

typedef struct engram_policy_reply engram_policy_reply;

/** Sets the actions of one row: shape (action_dim), (K, action_dim) or (1, K, action_dim). They are
 * queued and used one per step; the episode is asked for again when its queue is empty. For use in
 * the callback alone. */
ENGRAM_API engram_status engram_policy_set(engram_policy_reply* reply, int32_t row,
                                           const float* actions, const int64_t* shape,
                                           int32_t ndim);
/** Sets the reason why the policy cannot answer; the callback then returns something else than
 * 0. */
ENGRAM_API engram_status engram_policy_fail(engram_policy_reply* reply, const char* message);

/** Answers a request by setting every row; returns 0, or anything else to end the evaluation.
 * Called from several threads, by one at a time. */
typedef int (*engram_policy_callback)(void* user, const engram_policy_request* request,
                                      engram_policy_reply* reply);

/* A question to a policy that names answers instead of sending actions. Frames are the observations
 * since the episode's last question, or since it began; those that look like the one before are
 * left out, and the last one is of now. */
typedef struct engram_choice_question {
  size_t struct_size;
  const char* env_id;
  int32_t worker; /**< the thread's batch: 0 to threads - 1 */
  int32_t slot;   /**< place among the worker's episodes, 0 to max_slots - 1 */
  int32_t
      episode;  /**< opaque number, the same in every run; with tell_episodes that of the episode */
  int32_t step; /**< control steps taken so far */
  int32_t index; /**< of the question in its episode, from 0 */
  const char* instruction;
  const char* question;
  const char* const* choices; /**< `num_choices` texts, in an order that means nothing */
  size_t num_choices;
  int32_t least; /**< choices of an answer, at least and at most; and 1 if one may be named twice */
  int32_t most;
  int32_t repeats;
  size_t num_frames;
  const int32_t* frame_steps;
  const float* proprio;     /**< (num_frames, proprio_dim) */
  const uint8_t* rgb;       /**< (num_frames, height, width, 6), or NULL without images */
  const float* state;       /**< (num_frames, state_dim): state or objects, or NULL with images */
  const char* const* texts; /**< (num_frames) the objects in words, or NULL without objects */
  int32_t height;
  int32_t width;
  int32_t state_dim;
  int32_t proprio_dim;
  int32_t max_slots;
  const uint64_t* seed; /**< of the episode, with tell_episodes; otherwise NULL */
  uint64_t policy_seed; /**< of the policy's own random numbers */
} engram_choice_question;

typedef struct engram_choice_answer engram_choice_answer;

/** Names `count` choices by their indices, in the answer's order. For use in the callback alone. */
ENGRAM_API engram_status engram_choose(engram_choice_answer* answer, const int32_t* indices,
                                       size_t count);
/** The same by their texts, or by indices in digits. */
ENGRAM_API engram_status engram_choose_texts(engram_choice_answer* answer, const char* const* texts,
                                             size_t count);
/** Sets the reason why the policy cannot answer; the callback then returns something else than
 * 0. */
ENGRAM_API engram_status engram_choice_fail(engram_choice_answer* answer, const char* message);

/** Answers a question by engram_choose or engram_choose_texts; returns 0, or anything else to end
 * the evaluation. Called from several threads, by one at a time. */
typedef int (*engram_choice_callback)(void* user, const engram_choice_question* question,
                                      engram_choice_answer* answer);

/** Progress of an evaluation, reported several times a second by the thread that called
 * engram_evaluate. Returns 0, or anything else to end the evaluation. */
typedef int (*engram_progress_callback)(void* user, int32_t episodes, int32_t all_episodes,
                                        uint64_t env_steps);

typedef struct engram_evaluation_options {
  size_t struct_size;     /**< set by engram_evaluation_options_init */
  const char* const* ids; /**< `num_ids` tasks */
  size_t num_ids;
  int32_t episodes;        /**< per task; default 50 */
  int32_t num_envs;        /**< episodes that a thread plays together; default 8 */
  int32_t threads;         /**< default 0: one per core */
  int32_t obs_mode;        /**< ENGRAM_OBS_RGB (default), _STATE or _OBJECTS */
  uint64_t seed;           /**< episode i has seed + i; default 4242424242 */
  const char* name;        /**< of the policy, in the results; default "external" */
  const char* config_json; /**< an object: what else the results say of it; default NULL */
  const char* renderer;    /**< "cpu" (default) or "egl" */
  const char* output;      /**< results go to `<output>/<split>/<date_time>/`; default NULL: none */
  const char* resume; /**< folder of an interrupted run with these options, instead of output */
  const engram_task_option* task_options; /**< `num_task_options` of them; default none */
  size_t num_task_options;
  engram_progress_callback progress; /**< default NULL; gets the `user` of engram_evaluate */
  int32_t rules;                     /**< an engram_rules; default ENGRAM_RULES_REFERENCE */
  const char* constants; /**< of all tasks, a JSON object as in engram_options; default NULL */
  int32_t tell_episodes; /**< 1: requests have numbers and seeds of episodes; default 0 */
  const char* seed_file; /**< sealed evaluation: seeds follow from the secret line in this file, not
                            from `seed`; default NULL */
  int32_t repeat;        /**< rounds of the same episodes; round i has policy_seed + i; default 1 */
  uint64_t policy_seed;  /**< told to the policy in every request; default 0 */
  const char* latency;   /**< control steps from a request to its answer, such as "3", or
                            milliseconds, "120ms": the world goes on with the last action meanwhile;
                            default NULL: 0 */
  const char* control_mode; /**< meaning of actions; default NULL: the tasks' own */
  int32_t joint_proprio;    /**< 1: proprio has the arm's seven joint angles and the gripper's
                               opening; default 0 */
  const engram_perturbation* perturbations; /**< `num_perturbations` of them; default none */
  size_t num_perturbations;
  int32_t choices_stride; /**< engram_evaluate_choices: control steps between the frames of
                             questions; default 1 */
} engram_evaluation_options;

ENGRAM_API void engram_evaluation_options_init(engram_evaluation_options* options);

/** Runs the benchmark's evaluation protocol with a policy of the caller's. *document: {summary,
 * tasks} as JSON, as `engram eval --json` prints it, to be freed by engram_free_text; NULL if the
 * call fails. */
ENGRAM_API engram_status engram_evaluate(const engram_evaluation_options* options,
                                         engram_policy_callback policy, void* user,
                                         char** document);
/** The same with a policy that names answers, which a scripted hand carries out. For tasks whose
 * `choices` in engram_describe_json is not null. */
ENGRAM_API engram_status engram_evaluate_choices(const engram_evaluation_options* options,
                                                 engram_choice_callback policy, void* user,
                                                 char** document);
ENGRAM_API void engram_free_text(char* text);

/** Probes whether a policy reads its memory (docs/probe.md). options: as of an evaluation, without
 * resume, seed_file and repeat; output: folder of probe.json and probe.html. probes: some of
 * "twins,forgetting,interference,capacity", NULL for all. other: id of the task of further episodes
 * of interference, or NULL. *document: {settings, other, tasks} as JSON, as `engram probe --json`
 * prints it, to be freed by engram_free_text; NULL if the call fails. */
ENGRAM_API engram_status engram_probe(const engram_evaluation_options* options, const char* probes,
                                      const char* other, engram_policy_callback policy, void* user,
                                      char** document);

/** Named lists of tasks that results are published on, as JSON: {name: {ids, episodes, seed}}.
 * Valid for the life of the process. NULL, with a message, if there is no memory for it. */
ENGRAM_API const char* engram_suites_json(void);

/** Compares two results of evaluations episode by episode. a, b: folders of runs, JSON files of
 * results, or texts of such documents. allowed: `num_allowed` of "ids", "seeds", "version",
 * "rules", "constants" and "choices", in which they may differ. *document: as `engram compare
 * --json` prints it, to be freed by engram_free_text; NULL if the call fails. */
ENGRAM_API engram_status engram_compare(const char* a, const char* b, const char* const* allowed,
                                        size_t num_allowed, char** document);
/** A table of results. format: "md", "latex", "csv", "episodes" or "vla-eval". *table: as
 * `engram report` prints it, to be freed by engram_free_text; NULL if the call fails. */
ENGRAM_API engram_status engram_report(const char* results, const char* format, char** table);

#ifdef __cplusplus
}
#endif

/* NOLINTEND(readability-identifier-naming,modernize-use-using,modernize-deprecated-headers) */

#endif
