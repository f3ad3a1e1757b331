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
 * must not be used any more.
 *
 * Statuses, options and evaluation have headers of their own, which this one includes. */
#ifndef ENGRAM_ENGRAM_C_H
#define ENGRAM_ENGRAM_C_H

/* NOLINTBEGIN(readability-identifier-naming,modernize-use-using,modernize-deprecated-headers):
 * this is C */

#include <stddef.h>
#include <stdint.h>

#include "engram_base_c.h"
#include "engram_evaluation_c.h"
#include "engram_options_c.h"

#ifdef __cplusplus
extern "C" {
#endif

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
/** Loads a library of tasks (docs/cpp_tasks.md) for the life of the process; the same library
 * twice is one. Its code runs with all rights of the process. Fails with ENGRAM_IO if the file
 * cannot be read, ENGRAM_INVALID_ARGUMENT if it is no such library, was made for another version
 * of engram or with another ABI, or one of its ids is taken. */
ENGRAM_API engram_status engram_load_tasks(const char* path);

/* ---- life of a batch ---- */

typedef struct engram_env engram_env;

/** Makes a batch of the task with that id. options: NULL for the defaults, else initialised by
 * engram_options_init; nothing in it is used after the call. Fails with ENGRAM_UNKNOWN_ID (the
 * message names the nearest id), ENGRAM_INVALID_ARGUMENT or ENGRAM_UNAVAILABLE, and then *env is
 * NULL. */
ENGRAM_API engram_status engram_make(const char* id, const engram_options* options,
                                     engram_env** env);

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

/* begin generated: policy (tools/surface, from api/surface.toml) */
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
/* end generated */

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

/** From the first reset on, outputs are written to arrays of the caller's, which outlive the
 * handle. Arrays of images that engram_output returned before are no longer valid: images are drawn
 * into the caller's alone, to which it then points. targets: `turns` times `count` arrays, one turn
 * after the other, each turn for the same outputs: the first reset writes to those of turn 0, each
 * step to those of the next turn, after the last one to those of turn 0 again. With two turns, one
 * can be read while a step_async writes the other; many hold a rollout. Refused after the first
 * reset, for 0 turns, and for a name or size that is wrong. */
ENGRAM_API engram_status engram_write_outputs(engram_env* env, const engram_output_target* targets,
                                              size_t turns, size_t count);
/** The turn, from 0 on, whose arrays the last reset or step has written to. */
ENGRAM_API int32_t engram_output_buffer(const engram_env* env);

/** The language instruction of one environment's episode. Copies at most `capacity` bytes, the
 * closing 0 included, and sets *length (may be NULL) to the length without it. */
ENGRAM_API engram_status engram_instruction(engram_env* env, int32_t index, char* text,
                                            size_t capacity, size_t* length);

/* begin generated: text_queries (tools/surface, from api/surface.toml) */
/** One environment's episode in words, as JSON: plan (the subtasks), subtask (index of the present
 * one), subtasks_done, memory (what has been shown and has to be remembered), object (that is
 * meant, or null), and paraphrases of the instruction (these for policies too). Privileged: not for
 * policies. Copies as engram_instruction does. */
ENGRAM_API engram_status engram_words(engram_env* env, int32_t index, char* text, size_t capacity,
                                      size_t* length);
/** The question of one environment's episode (docs/choices.md), as JSON: due (the policy cannot go
 * on without an answer), question, choices (in an order that means nothing), least and most (of an
 * answer), repeats (one may be named twice). Copies as engram_instruction does. */
ENGRAM_API engram_status engram_question(engram_env* env, int32_t index, char* text,
                                         size_t capacity, size_t* length);
/* end generated */

/** Questions (docs/choices.md) while an episode runs: the caller names the answer, and
 * ENGRAM_POLICY_BLIND of engram_act carries it out. engram_ask: from now on that policy waits in
 * one environment's episode until the question is answered, instead of guessing; to be called after
 * each reset. Refused for tasks without choices ("choices" of engram_describe_json is null). */
ENGRAM_API engram_status engram_ask(engram_env* env, int32_t index);
/** Answers the question by `count` indices of its choices, in order. Refused with ENGRAM_BAD_STATE
 * if none is due. */
ENGRAM_API engram_status engram_answer(engram_env* env, int32_t index, const int32_t* choices,
                                       size_t count);

/** Draws one environment as it is now, row 0 on top. camera: one of the scene's
 * (docs/robot.md); sides 1 to 4096 pixels; rgb: size = height * width * 3 bytes. */
ENGRAM_API engram_status engram_render(engram_env* env, int32_t index, const char* camera,
                                       int32_t width, int32_t height, uint8_t* rgb, size_t size);

/* ---- queries: no part of observations ---- */

/* begin generated: array_queries */
/** The robot in all environments, in every observation mode: qpos (N, 9) and qvel (N, 9), arm
 * joints and fingers, rad and m; tcp_pose (N, 7), position in m and quaternion (w, x, y, z) in the
 * world. NULL: not wanted. Refused with ENGRAM_BAD_STATE before the first reset. */
ENGRAM_API engram_status engram_robot_state(engram_env* env, float* qpos, float* qvel,
                                            float* tcp_pose);
/** A camera of the scene in all environments, for images of that size: extrinsic_cv (N, 3, 4), from
 * the world to the camera (x right, y down, z forward); cam2world_gl (N, 4, 4), from the camera (x
 * right, y up, z backward) to the world; intrinsic_cv (N, 3, 3), in pixels, where pixel (0, 0)
 * covers 0 to 1. NULL: not wanted. Refused with ENGRAM_BAD_STATE before the first reset. */
ENGRAM_API engram_status engram_camera_params(engram_env* env, const char* camera, int32_t width,
                                              int32_t height, float* extrinsic_cv,
                                              float* cam2world_gl, float* intrinsic_cv);
/* end generated */
/** Values that an episode has drawn, such as the lengths of its phases: how many of them there are
 * (0 in a batch of several tasks; "drawn" of engram_describe_json names them, in order), and those
 * of all environments, row by row; count: N * engram_drawn_dim. They reveal what policies must not
 * know. */
ENGRAM_API int32_t engram_drawn_dim(const engram_env* env);
ENGRAM_API engram_status engram_drawn(engram_env* env, float* values, size_t count);

/* ---- MuJoCo's own structures: of batches whose option physics is ENGRAM_PHYSICS_MUJOCO ---- */

struct mjModel_; /**< MuJoCo's mjModel */
struct mjData_;  /**< MuJoCo's mjData */

/** *model: the mjModel of one environment's task, for code that is compiled with the headers of the
 * version that engram_mujoco_version names. The batch owns it: to be read, until engram_close.
 * Other tasks of a batch have other models. Fails with ENGRAM_INVALID_ARGUMENT if the physics is
 * engram's own or there is no such environment, and then *model is NULL. */
ENGRAM_API engram_status engram_mujoco_model(engram_env* env, int32_t index,
                                             const struct mjModel_** model);
/** *data: the mjData of one environment as it is now, with all that mj_forward computes. Its
 * address stays until engram_close; resets and steps change the content, which the next call brings
 * up to date. Fails as engram_mujoco_model does, and with ENGRAM_BAD_STATE before the first reset.
 */
ENGRAM_API engram_status engram_mujoco_data(engram_env* env, int32_t index,
                                            const struct mjData_** data);
/** Version of MuJoCo, "2.2.2". */
ENGRAM_API const char* engram_mujoco_version(void);

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

#ifdef __cplusplus
}
#endif

/* NOLINTEND(readability-identifier-naming,modernize-use-using,modernize-deprecated-headers) */

#endif
