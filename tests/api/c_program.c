/* A program in C as users write them: rolls out the oracle and checks what comes out. Exits with 0
 * if all is well; says what is not. */
#include <engram/engram_c.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { NUM_ENVS = 8 };

static int failures = 0;

static void expect(int good, const char* what) {
  if (good) return;
  ++failures;
  fprintf(stderr, "failed: %s (last error: %s)\n", what, engram_last_error());
}

static engram_env* make_batch(void) {
  static const double target[] = {2};
  const engram_pin pin = {"target", target, 1};
  engram_options options;
  engram_env* env = NULL;
  engram_options_init(&options);
  options.num_envs = NUM_ENVS;
  options.threads = 2;
  options.seed = 7;
  options.auto_reset = ENGRAM_AUTO_RESET_SAME_STEP;
  options.pins = &pin;
  options.num_pins = 1;
  expect(engram_make("RememberColor3-VLA-v0", &options, &env) == ENGRAM_OK, "engram_make");
  return env;
}

static engram_array output(engram_env* env, const char* name) {
  engram_array array;
  memset(&array, 0, sizeof array);
  expect(engram_output(env, name, &array) == ENGRAM_OK, name);
  return array;
}

/* Runs one episode of every environment and returns how many of them succeeded. */
static int run_episode(engram_env* env) {
  const size_t count = NUM_ENVS * (size_t)engram_action_dim(env);
  float* actions = calloc(count, sizeof *actions);
  const uint8_t* ended = output(env, "final_mask").data;
  engram_array success;
  int successes = 0;
  int step;
  int i;
  expect(actions != NULL, "calloc");
  expect(engram_final_output(env, "success_once", &success) == ENGRAM_OK, "final output");
  expect(engram_reset(env, NULL) == ENGRAM_OK, "engram_reset");
  for (step = 0; step < engram_horizon(env); ++step) {
    expect(engram_act(env, ENGRAM_POLICY_ORACLE, actions, count) == ENGRAM_OK, "engram_act");
    if (step % 2 == 0) {
      expect(engram_step(env, actions, count) == ENGRAM_OK, "engram_step");
    } else {
      expect(engram_step_async(env, actions, count) == ENGRAM_OK, "engram_step_async");
      expect(engram_step_wait(env) == ENGRAM_OK, "engram_step_wait");
    }
    for (i = 0; i < NUM_ENVS; ++i) {
      if (ended[i]) successes += ((const uint8_t*)success.data)[i];
    }
  }
  free(actions);
  return successes;
}

static void check_outputs(engram_env* env) {
  const engram_array observation = output(env, "observation");
  const engram_array oracle = output(env, "oracle_info");
  char text[200];
  size_t length = 0;
  uint8_t* image = malloc(64 * 48 * 3);
  expect(observation.ndim == 2 && observation.shape[0] == NUM_ENVS, "shape of observations");
  expect(observation.shape[1] == engram_state_dim(env), "width of observations");
  expect(observation.dtype == ENGRAM_FLOAT32, "type of observations");
  expect(((const int32_t*)oracle.data)[NUM_ENVS - 1] == 2, "the pinned target");
  expect(engram_instruction(env, 0, text, sizeof text, &length) == ENGRAM_OK, "instruction");
  expect(length > 0 && strlen(text) == length, "length of the instruction");
  expect(image != NULL, "malloc");
  expect(engram_render(env, 0, "base_camera", 64, 48, image, 64 * 48 * 3) == ENGRAM_OK, "render");
  free(image);
}

static void check_snapshot(engram_env* env) {
  const engram_array observation = output(env, "observation");
  const size_t bytes = NUM_ENVS * (size_t)observation.shape[1] * sizeof(float);
  size_t size = 0;
  void* snapshot;
  void* before = malloc(bytes);
  expect(engram_save(env, ENGRAM_WHOLE_BATCH, NULL, 0, &size) == ENGRAM_OK && size > 0, "size");
  snapshot = malloc(size);
  expect(snapshot != NULL && before != NULL, "malloc");
  expect(engram_save(env, ENGRAM_WHOLE_BATCH, snapshot, size, &size) == ENGRAM_OK, "engram_save");
  memcpy(before, observation.data, bytes);
  expect(engram_reset(env, NULL) == ENGRAM_OK, "engram_reset");
  expect(memcmp(before, observation.data, bytes) != 0, "a reset changes the observation");
  expect(engram_restore(env, ENGRAM_WHOLE_BATCH, snapshot, size) == ENGRAM_OK, "engram_restore");
  expect(memcmp(before, observation.data, bytes) == 0, "a snapshot brings it back");
  free(snapshot);
  free(before);
}

static void check_errors(engram_env* env) {
  engram_array array;
  engram_env* none = NULL;
  expect(engram_output(env, "colour", &array) == ENGRAM_UNKNOWN_ID, "unknown output");
  expect(strstr(engram_last_error(), "colour") != NULL, "message of an unknown output");
  expect(engram_make("RememberColour3-VLA-v0", NULL, &none) == ENGRAM_UNKNOWN_ID, "unknown id");
  expect(none == NULL, "no batch of an unknown id");
  expect(strstr(engram_last_error(), "RememberColor3-VLA-v0") != NULL, "the nearest id");
}

int main(void) {
  engram_env* env = make_batch();
  if (env == NULL) return 1;
  expect(engram_num_tasks() > 0, "number of tasks");
  expect(strcmp(engram_task_id(0), "ShellGameTouch-VLA-v0") == 0, "first task");
  expect(run_episode(env) >= NUM_ENVS - 1, "the oracle succeeds");
  check_outputs(env);
  check_snapshot(env);
  check_errors(env);
  engram_close(env);
  printf("engram %s: %d failures\n", engram_version(), failures);
  return failures == 0 ? 0 : 1;
}
