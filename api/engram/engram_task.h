/** @file
 * engram: tasks of a user's own, with rules that are callbacks over arrays. The plain C API.
 *
 * A task is one scene and rules over columns: arrays with one row per environment. What it consists
 * of is described in JSON; its rules are called once a step for all environments of the batch that
 * are concerned, by the thread that steps the batch. docs/custom_tasks.md has the keys of the JSON
 * texts and the columns; `engram.Task` in Python stands on this. */
#ifndef ENGRAM_ENGRAM_TASK_H
#define ENGRAM_ENGRAM_TASK_H

/* NOLINTBEGIN(readability-identifier-naming,modernize-use-using,modernize-deprecated-headers):
 * this is C */

#include "engram_c.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ---- rules ---- */

typedef enum engram_task_method {
  ENGRAM_TASK_RESET = 0, /**< of new episodes: columns are zero, the draws have been drawn */
  ENGRAM_TASK_BEFORE_PHYSICS = 1, /**< moves kinematic props */
  ENGRAM_TASK_ADVANCE = 2,        /**< brings the scene to the phase of `elapsed` */
  ENGRAM_TASK_EVALUATE = 3,       /**< success, failed, answers, infos */
  ENGRAM_TASK_REWARD = 4,         /**< the dense reward */
  ENGRAM_TASK_OBSERVE = 5,        /**< the state fields */
  ENGRAM_TASK_ORACLE = 6,         /**< actions of scripted policies */
  ENGRAM_TASK_BLIND = 7,
  ENGRAM_TASK_SWEEP = 8
} engram_task_method;

/** Memory of a column, which may be kept longer than the task. */
typedef struct engram_task_memory engram_task_memory;

/** A column: (N, width) numbers. */
typedef struct engram_task_array {
  const char* name; /**< valid until the task is destroyed */
  int32_t dtype;    /**< an engram_dtype */
  int32_t width;
  int32_t is_written;         /**< 1: what the rules write there counts */
  void* all;                  /**< rows of all environments */
  void* subset_rows;          /**< as many spare rows, for calls that concern some environments */
  engram_task_memory* memory; /**< of both */
} engram_task_array;

/** Keeps the memory of a column until as many calls of engram_task_memory_release. */
ENGRAM_API void engram_task_memory_retain(engram_task_memory* memory);
ENGRAM_API void engram_task_memory_release(engram_task_memory* memory);

typedef struct engram_task_reply engram_task_reply;
/** Sets what `create` says of the task, a JSON object. For use in that callback alone. */
ENGRAM_API void engram_task_describe(engram_task_reply* reply, const char* json);
/** Sets the reason why a callback fails; it then returns something else than 0. */
ENGRAM_API void engram_task_fail(engram_task_reply* reply, const char* message);

/** Callbacks of a task; each returns 0, or anything else to fail. They may come from any thread;
 * those of one instance come one at a time. */
typedef struct engram_task_callbacks {
  size_t struct_size; /**< sizeof(engram_task_callbacks) */
  /** Makes the task of one batch, or of a description, and describes it. constants: the values of
   * all constants, a JSON object. */
  int (*create)(void* user, const char* id, const char* constants, void** instance,
                engram_task_reply* reply);
  /** Gives it the columns of a batch. */
  int (*bind)(void* instance, const engram_task_array* arrays, size_t count, int32_t num_envs,
              engram_task_reply* reply);
  /** Works on all rows of `all`, or else on the first `rows` rows of `subset_rows`. method: an
   * engram_task_method. */
  int (*call)(void* instance, int32_t method, int32_t rows, int32_t of_all,
              engram_task_reply* reply);
  void (*destroy)(void* instance);
} engram_task_callbacks;

/** Registers a task for the life of the process. definition: a JSON object. The same id of the same
 * family again takes the place of the earlier one. Fails with ENGRAM_INVALID_ARGUMENT if the
 * definition or the description cannot be used, or the id is another task's; ENGRAM_TASK_FAILED if
 * a callback fails. */
ENGRAM_API engram_status engram_register_task(const char* definition,
                                              const engram_task_callbacks* callbacks, void* user);

/* ---- what scripted policies are built on: arrays with `count` rows ---- */

/** Actions (count, 7) of pd_ee_delta_pose that bring the TCP (positions (count, 3) m, quaternions
 * (count, 4) w, x, y, z) to goals (count, 3) m and orientations (count, 4) as fast as the drives
 * allow; grippers (count): -1 to 1. */
ENGRAM_API engram_status engram_servo_tcp(int32_t count, const double* tcp_pos,
                                          const double* tcp_quat, const double* goals,
                                          const double* orientations, const double* grippers,
                                          float* actions);
/** Waypoints (count, 3): `clearance` m above the goals until the TCP is nearly overhead. */
ENGRAM_API engram_status engram_approach_from_above(int32_t count, const double* tcp_pos,
                                                    const double* goals, double clearance,
                                                    double* waypoints);
/** Waypoints (count, 3): the TCP keeps above a narrow funnel around the goals, never above
 * travel_height m unless a goal is. */
ENGRAM_API engram_status engram_descend(int32_t count, const double* tcp_pos, const double* goals,
                                        double travel_height, double* waypoints);
/** Orientations (count, 4), tilted outwards for points (count, 3) m that are more than `reach` m
 * away from the robot's base, by per_metre rad/m, at most by `most` rad. */
ENGRAM_API engram_status engram_tilt_outwards(int32_t count, const double* orientations,
                                              const double* points, double reach, double per_metre,
                                              double most, double* tilted);
/** Next goals (count, 3) of a tour over stops (count, num_stops, 3) m for policies without memory;
 * num_stops: 1 to 16. rests (count): 1: brake, to be still. start_height m: a TCP above that has
 * not begun; reach m: around a stop; again: one tour after another, by the step count; needs_rest:
 * the TCP rests at every stop. */
ENGRAM_API engram_status engram_tour(int32_t count, const double* tcp_pos, const double* qvel,
                                     const int32_t* elapsed, const double* stops, int32_t num_stops,
                                     double start_height, double reach, int32_t again,
                                     int32_t needs_rest, double* goals, uint8_t* rests);
/** held (count): 1 where both fingers measure at least min_force N within max_angle degrees of
 * their opening directions. finger_force: (count, num_props, 2, 3) N. */
ENGRAM_API engram_status engram_is_grasping(int32_t count, const double* tcp_quat,
                                            const double* finger_force, int32_t num_props,
                                            int32_t prop, double min_force, double max_angle,
                                            uint8_t* held);
/** Numbers (count, width) in [0, 1) of the blind policy, the same ones in every step of an episode;
 * keys, episodes: the columns policy_key and episode. */
ENGRAM_API engram_status engram_guesses(int32_t count, const uint64_t* keys,
                                        const uint64_t* episodes, int32_t width, double* numbers);
/** A function with the same bits on every machine: sin, cos, tan, exp, log, asin, tanh of x; atan2
 * (of x over y), hypot of x and y. y: NULL where the function has one argument. */
ENGRAM_API engram_status engram_real_function(const char* name, size_t count, const double* x,
                                              const double* y, double* values);

#ifdef __cplusplus
}
#endif

/* NOLINTEND(readability-identifier-naming,modernize-use-using,modernize-deprecated-headers) */

#endif
