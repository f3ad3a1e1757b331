/** @file
 * engram: the preset for training, with which plain learners with default hyperparameters learn.
 * The plain C API; docs/learning.md has the reasons and the equations.
 *
 *     engram_options options;
 *     engram_options_init(&options);
 *     options.num_envs = 64;
 *     options.terminate_on_success = 1;
 *     options.auto_reset = ENGRAM_AUTO_RESET_SAME_STEP;
 *     engram_env* env = NULL;
 *     engram_training* training = NULL;
 *     if (engram_make("RememberColor3-VLA-v0", &options, &env) != ENGRAM_OK ||
 *         engram_training_make(env, NULL, &training) != ENGRAM_OK)
 *       puts(engram_last_error());
 *     engram_training_reset(training, NULL);
 *     engram_training_step(training, actions, 64 * engram_action_dim(env));
 *     engram_training_close(training);
 *     engram_close(env);
 *
 * Statuses, messages and threads are those of engram_c.h: a failing call changes nothing, and a
 * training handle is in use whenever its batch is. N stands for the number of environments. */
#ifndef ENGRAM_ENGRAM_TRAINING_C_H
#define ENGRAM_ENGRAM_TRAINING_C_H

/* NOLINTBEGIN(readability-identifier-naming,modernize-use-using,modernize-deprecated-headers):
 * this is C */

#include <stddef.h>
#include <stdint.h>

#include "engram_c.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct engram_training_options {
  size_t struct_size; /**< set by engram_training_options_init */
  /* begin generated: fields (tools/surface, from api/surface.toml) */
  /** Discount of the learner; more than 0, up to 1. Default 0.99. */
  double gamma;
  /** An action of 1 is 0.3 of the arm's largest motion, 0.1 of its largest rotation, 0.5 of the
   * gripper's; larger ones reach the limits. Default 1. */
  int32_t scale_actions;
  /** Weight of an episode's past actions in the next one; 0 (none) to less than 1. Default 0.0. */
  double smoothing;
  /** Rows of states in fixed units from the TCP, rows of objects in a lasting order too. Default 1.
   * */
  int32_t scale_observations;
  /** One more column where there are rows: the share of the horizon that is left. Default 1. */
  int32_t time_left;
  /** Weight of the dense reward in the potential whose differences are the reward, 0 or more; 0: no
   * potential, the reward is the batch's own. Default 1.0. */
  double potential;
  /** Weight of standing still in the potential, where the arm has to, 0 (none) or more. Default
   * 0.0. */
  double still;
  /** For each step that the first success leaves of the horizon, discounted, 0 (none) or more.
   * Default 0.1. */
  double bonus;
  /* end generated */
} engram_training_options;

/** Sets all defaults. */
ENGRAM_API void engram_training_options_init(engram_training_options* options);

typedef struct engram_training engram_training;

/** Makes the preset for a batch of one task or several, in any mode of automatic resets. The batch
 * stays the caller's, and its outputs stay the benchmark's own, the reward included; it is closed
 * after the training handle. From here on it is reset and stepped by these functions alone:
 * engram_reset, engram_step and engram_restore do not tell the preset. options: NULL for the
 * defaults. Fails with ENGRAM_INVALID_ARGUMENT for an option outside its range, and unless episodes
 * end at success (options.terminate_on_success); then *training is NULL. */
ENGRAM_API engram_status engram_training_make(engram_env* env,
                                              const engram_training_options* options,
                                              engram_training** training);
/** Frees what the preset owns; NULL is allowed. */
ENGRAM_API void engram_training_close(engram_training* training);

/** Starts new episodes, as engram_reset does; the first call those of all environments, also where
 * the batch runs already. Fails with ENGRAM_BAD_STATE otherwise. */
ENGRAM_API engram_status engram_training_reset(engram_training* training,
                                               const engram_reset_request* request);
/** One control step. actions: (N, action_dim) floats, row by row, in the range of
 * engram_training_action_low and high, to which they are clipped; count: N * action_dim. Refused as
 * engram_step refuses, and before engram_training_reset. */
ENGRAM_API engram_status engram_training_step(engram_training* training, const float* actions,
                                              size_t count);

/** Least and greatest value of each action component, engram_action_dim of them; infinite where
 * there is no bound. */
ENGRAM_API const float* engram_training_action_low(const engram_training* training);
ENGRAM_API const float* engram_training_action_high(const engram_training* training);

/** Floats of an observation; 0 where the batch has no rows (obs_mode none, or images alone). */
ENGRAM_API int32_t engram_training_observation_dim(const engram_training* training);

/* Arrays of the last reset or step, which stay where they are for the life of the handle. The
 * batch's other outputs (terminated, truncated, success_once, final_mask, ...) belong to them. */

/** (N, observation_dim), without units, scaled values in -10 to 10. */
ENGRAM_API const float* engram_training_observation(const engram_training* training);
/** (N, observation_dim) at the end of the episode that ended last in each environment; the batch's
 * final_mask is 1 where that was in this step. NULL unless auto_reset is same-step. */
ENGRAM_API const float* engram_training_final_observation(const engram_training* training);
/** (N) of this step, of ended episodes the last one; 0 after a reset. */
ENGRAM_API const float* engram_training_reward(const engram_training* training);

#ifdef __cplusplus
}
#endif

/* NOLINTEND(readability-identifier-naming,modernize-use-using,modernize-deprecated-headers) */

#endif
