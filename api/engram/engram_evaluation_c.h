/** @file
 * engram: evaluation and probes of policies of the caller's, comparison and tables of results. A
 * part of the C API; include engram_c.h. */
#ifndef ENGRAM_ENGRAM_EVALUATION_C_H
#define ENGRAM_ENGRAM_EVALUATION_C_H

/* NOLINTBEGIN(readability-identifier-naming,modernize-use-using,modernize-deprecated-headers):
 * this is C */

#include <stddef.h>
#include <stdint.h>

#include "engram_base_c.h"
#include "engram_options_c.h"

#ifdef __cplusplus
extern "C" {
#endif

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
/** Tells what the policy is, as a JSON object such as {"checkpoint": "sha256:..."}, which an
 * evaluation with output keeps in policy.json. Another checkpoint than before ends it. */
ENGRAM_API engram_status engram_policy_identify(engram_policy_reply* reply, const char* identity);

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
  size_t struct_size; /**< set by engram_evaluation_options_init */
  /* begin generated: fields (tools/surface, from api/surface.toml) */
  /** Tasks, `num_ids` of them. */
  const char* const* ids;
  size_t num_ids;
  /** Episodes of each task. 1 or more; default 50. */
  int32_t episodes;
  /** Episodes that a thread plays together. 1 or more; default 8. */
  int32_t num_envs;
  /** Threads that play episodes; results do not depend on it. 0 (one per core) or more; default 0.
   * */
  int32_t threads;
  /** Observations of the policy: ENGRAM_OBS_RGB, ENGRAM_OBS_STATE or ENGRAM_OBS_OBJECTS. An
   * engram_obs_mode; default ENGRAM_OBS_RGB. */
  int32_t obs_mode;
  /** Episode i has seed + i. Default 4242424242. */
  uint64_t seed;
  /** Name of the policy in the results. Default NULL: external. */
  const char* name;
  /** An object: further description of the policy in the results. Default NULL: {}. */
  const char* config_json;
  /** Renderer of rgb observations. "cpu" or "egl"; default NULL: cpu. */
  const char* renderer;
  /** Results go to `<output>/<split>/<date_time>/`. Default NULL: none. */
  const char* output;
  /** Folder of an interrupted run with these options, instead of output. Default NULL: none. */
  const char* resume;
  /** Variants of the tasks' rules, by name. Default none. */
  const engram_task_option* task_options; /**< num_task_options of them */
  size_t num_task_options;
  /** Callback, which gets the `user` of engram_evaluate. */
  engram_progress_callback progress;
  /** Rule set of the tasks. An engram_rules; default ENGRAM_RULES_REFERENCE. */
  int32_t rules;
  /** Constants of all tasks. Default none. */
  const char* constants; /**< a JSON object: {"COLORS": 7, "CUE_PHASE_STEPS": [3, 5]}; NULL: none */
  /** Requests have numbers and seeds of episodes. Default 0. */
  int32_t tell_episodes;
  /** Sealed evaluation: seeds follow from the secret line in this file, not from `seed`. Default
   * NULL: none. */
  const char* seed_file;
  /** Rounds of the same episodes; round i has policy_seed + i. 1 to 1000; default 1. */
  int32_t repeat;
  /** Seed of the policy's own random numbers, part of every request. Default 0. */
  uint64_t policy_seed;
  /** Control steps from a request to its answer, such as "3", or milliseconds, "120ms": the world
   * goes on with the last action meanwhile. Default NULL: 0. */
  const char* latency;
  /** Meaning of actions. Default NULL: the tasks' own. */
  const char* control_mode;
  /** Proprio has the arm's seven joint angles and the gripper's opening, instead of the TCP's pose
   * and the opening. Default 0. */
  int32_t joint_proprio;
  /** Departures from the tasks' usual scenes, robot and words. Default none. */
  const engram_perturbation* perturbations; /**< num_perturbations of them */
  size_t num_perturbations;
  /** Interval of the frames of questions, for engram_evaluate_choices. 1 to 1,000,000 control
   * steps; default 1. */
  int32_t choices_stride;
  /** Engine that moves robot and props. An engram_physics; default ENGRAM_PHYSICS_ENGRAM. */
  int32_t physics;
  /** "I/N": plays share I of N alone, into `<output>/shard-I-of-N/`, for engram_merge. Default
   * NULL: none. */
  const char* shard;
  /* end generated */
} engram_evaluation_options;

ENGRAM_API void engram_evaluation_options_init(engram_evaluation_options* options);

/** Runs the benchmark's evaluation protocol with a policy of the caller's. *document: {summary,
 * tasks} as JSON, as `engram eval --json` prints it, or {shard, out, episodes} of a shard, to be
 * freed by engram_free_text; NULL if the call fails. */
ENGRAM_API engram_status engram_evaluate(const engram_evaluation_options* options,
                                         engram_policy_callback policy, void* user,
                                         char** document);
/** The same with a policy that names answers, which a scripted hand carries out. For tasks whose
 * `choices` in engram_describe_json is not null. */
ENGRAM_API engram_status engram_evaluate_choices(const engram_evaluation_options* options,
                                                 engram_choice_callback policy, void* user,
                                                 char** document);

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

/** Makes one result of the shards of an evaluation (`shard` of the options), with the bytes of one
 * process. folders: `num_folders` folders of shards, or those that have them. output: the result
 * goes to `<output>/<split>/<date_time>/`; NULL: beside the first shard. *document: as of
 * engram_evaluate; NULL if the call fails, as where episodes are missing. */
ENGRAM_API engram_status engram_merge(const char* const* folders, size_t num_folders,
                                      const char* output, char** document);
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
