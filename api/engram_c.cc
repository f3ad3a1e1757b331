// The C API: nothing but checks and conversions in front of Batch.
#include "engram/engram_c.h"

#include <chrono>
#include <cstdlib>
#include <cstring>
#include <thread>

#include "api/c_batch.h"
#include "api/c_error.h"
#include "api/c_options.h"
#include "api/c_text.h"
#include "core/base/join.h"
#include "core/batch/scripted_policy.h"
#include "protocol/make/environment_files.h"
#include "protocol/make/group_description.h"
#include "protocol/make/task_description.h"
#include "protocol/make/variants.h"

namespace {

using engram::Error;
using engram::OutputArray;
using engram::c::CallGuard;
using engram::c::CallState;
using engram::c::fail;
using engram::c::give_text;
using engram::c::guarded;
using engram::c::refuse_busy;
using engram::c::refuse_forked;
using engram::c::refuse_null;
using engram::c::with_call;
using engram::c::with_env;

// A constant of a batch, or `otherwise` for NULL. Constants can be read at any time, even while
// another call is at work.
template <class T, class F>
T constant(const engram_env* env, T otherwise, F&& f) noexcept {
  if (env != nullptr) return f(*env);
  refuse_null("env");
  return otherwise;
}

engram_array named(const std::vector<OutputArray>& arrays, const char* name) {
  const OutputArray* const found = engram::find_array(arrays, name);
  if (found != nullptr) return engram::c::to_array(*found);
  std::vector<std::string> names;
  names.reserve(arrays.size());
  for (const OutputArray& array : arrays) names.push_back(array.field.name);
  throw Error(Error::kUnknownId, "no output named '" + std::string(name) +
                                     "'; this batch has: " + engram::join(names));
}

}  // namespace

const char* engram_last_error() { return engram::c::last_error(); }

const char* engram_version() { return engram::version(); }

void engram_free_text(char* text) { std::free(text); }

// ---- life of a batch ----

void engram_options_init(engram_options* options) {
  if (options == nullptr) {
    refuse_null("options");
    return;
  }
  *options = engram::c::default_options();
}

namespace {

// Options as given; NULL: the defaults.
engram::MakeOptions given_options(const engram_options* options) {
  engram::load_environment_files();
  return engram::c::to_make_options(options != nullptr ? *options : engram::c::default_options());
}

}  // namespace

engram_status engram_make(const char* id, const engram_options* options, engram_env** env) {
  if (env == nullptr) return refuse_null("env");
  *env = nullptr;
  if (id == nullptr) return refuse_null("id");
  return guarded([&] {
    *env = std::make_unique<engram_env>(engram::make(id, given_options(options))).release();
  });
}

engram_status engram_make_group(const engram_task_share* tasks, size_t num_tasks,
                                const engram_options* options, engram_env** env) {
  if (env == nullptr) return refuse_null("env");
  *env = nullptr;
  if (tasks == nullptr) return refuse_null("tasks");
  return guarded([&] {
    std::vector<engram::TaskShare> shares;
    for (const engram_task_share& task : std::span(tasks, num_tasks)) {
      shares.push_back(engram::c::to_share(task));
    }
    auto batch = engram::make_group(shares, given_options(options));
    *env = std::make_unique<engram_env>(std::move(batch)).release();
  });
}

void engram_close(engram_env* env) {
  // A forked process cannot end the threads of another one.
  if (env == nullptr || env->forked()) return;
  // Waits for a call in another thread. A step_async without a step_wait ends with its driver.
  CallState found = env->use.load();
  while (found == CallState::kBusy || !env->use.compare_exchange_weak(found, CallState::kBusy)) {
    if (found == CallState::kBusy) std::this_thread::sleep_for(std::chrono::microseconds(100));
    found = env->use.load();
  }
  env->driver.reset();
  delete env;
}

// ---- facts about a batch ----

int32_t engram_num_envs(const engram_env* env) {
  return constant(env, 0, [](const engram_env& of) { return of.batch->num_envs(); });
}

int32_t engram_num_threads(const engram_env* env) {
  return constant(env, 0, [](const engram_env& of) { return of.batch->threads(); });
}

int32_t engram_action_dim(const engram_env* env) {
  return constant(env, 0, [](const engram_env& of) { return of.batch->action_dim(); });
}

int32_t engram_state_dim(const engram_env* env) {
  return constant(env, 0, [](const engram_env& of) { return of.batch->state_dim(); });
}

int32_t engram_horizon(const engram_env* env) {
  return constant(env, 0, [](const engram_env& of) { return of.batch->horizon(); });
}

const float* engram_action_low(const engram_env* env) {
  const float* none = nullptr;
  return constant(env, none,
                  [](const engram_env& of) { return of.batch->action_space().low.data(); });
}

const float* engram_action_high(const engram_env* env) {
  const float* none = nullptr;
  return constant(env, none,
                  [](const engram_env& of) { return of.batch->action_space().high.data(); });
}

const char* engram_describe_json(engram_env* env) {
  const char* text = nullptr;
  with_call(env, [env, &text](CallGuard&) {
    if (env->description.empty()) {
      env->description = engram::to_text(engram::describe_group(*env->batch));
    }
    text = env->description.c_str();
  });
  return text;
}

engram_status engram_describe_task_json(const char* id, const engram_options* options,
                                        char** description) {
  if (description == nullptr) return refuse_null("description");
  *description = nullptr;
  if (id == nullptr) return refuse_null("id");
  return guarded([&] {
    engram::MakeOptions given = given_options(options);
    engram::check_ranges(given);
    given.num_envs = 1;  // the description is the same for any number
    given.threads = 1;
    *description =
        engram::c::new_text(engram::to_text(engram::describe_task(*engram::make(id, given))));
  });
}

uint64_t engram_unstable_count(const engram_env* env) {
  return constant(env, uint64_t{0},
                  [](const engram_env& of) { return of.queries.unstable_count(); });
}

// ---- running it ----

engram_status engram_reset(engram_env* env, const engram_reset_request* request) {
  return with_env(env, [request](engram_env& of) {
    const engram::c::GivenReset given(request, of.batch->num_envs());
    of.batch->reset(given.request());
  });
}

engram_status engram_step(engram_env* env, const float* actions, size_t count) {
  if (actions == nullptr) return refuse_null("actions");
  return with_env(env, [&](engram_env& of) { of.batch->step(of.copied({actions, count})); });
}

engram_status engram_step_no_action(engram_env* env) {
  return with_env(env, [](engram_env& of) { of.batch->step_no_action(); });
}

engram_status engram_step_async(engram_env* env, const float* actions, size_t count) {
  if (actions == nullptr) return refuse_null("actions");
  return with_call(env, [&](CallGuard& call) {
    if (!env->driver) env->driver = std::make_unique<engram::c::StepDriver>(*env->batch);
    env->driver->start({actions, count});
    call.leave(CallState::kStepping);
  });
}

namespace {

// Calls f(claim) while no other call can wait for the step that is under way.
template <class F>
engram_status with_step(engram_env* env, F&& f) noexcept {
  if (env == nullptr) return refuse_null("env");
  if (env->forked()) return refuse_forked(*env);
  CallGuard call(*env, CallState::kStepping);
  if (call.acquired()) return guarded([&] { f(call); });
  if (call.found() == CallState::kBusy) return refuse_busy(CallState::kBusy);
  return fail(ENGRAM_BAD_STATE, "no step is under way; start one with step_async first");
}

}  // namespace

engram_status engram_step_wait(engram_env* env) {
  return with_step(env, [env](CallGuard&) { env->driver->wait(); });
}

engram_status engram_step_wait_for(engram_env* env, double seconds, int32_t* done) {
  if (done == nullptr) return refuse_null("done");
  *done = 0;
  constexpr double kLongest = 1e9;  // s
  if (!(seconds >= 0 && seconds <= kLongest)) {
    return fail(ENGRAM_INVALID_ARGUMENT, "seconds: 0 to 1e9 allowed");
  }
  return with_step(env, [&](CallGuard& call) {
    const std::chrono::duration<double> most(seconds);
    const bool ended =
        env->driver->wait_for(std::chrono::duration_cast<std::chrono::nanoseconds>(most));
    if (!ended) call.leave(CallState::kStepping);
    *done = ended ? 1 : 0;
  });
}

engram_status engram_act(engram_env* env, int32_t policy, float* actions, size_t count) {
  if (actions == nullptr) return refuse_null("actions");
  return with_env(env, [&](engram_env& of) {
    engram::ScriptedPolicy(*of.batch, engram::c::to_policy(policy)).act({actions, count});
  });
}

// ---- outputs ----

engram_status engram_output(engram_env* env, const char* name, engram_array* array) {
  if (name == nullptr) return refuse_null("name");
  if (array == nullptr) return refuse_null("array");
  return with_call(env,
                   [&](CallGuard&) { *array = named(env->batch->output_arrays().now(), name); });
}

engram_status engram_final_output(engram_env* env, const char* name, engram_array* array) {
  if (name == nullptr) return refuse_null("name");
  if (array == nullptr) return refuse_null("array");
  return with_call(env, [&](CallGuard&) {
    if (env->batch->output_arrays().finals().empty()) {
      throw Error(Error::kBadState, "final outputs are kept with auto-reset same-step only");
    }
    *array = named(env->batch->output_arrays().finals(), name);
  });
}

size_t engram_num_outputs(const engram_env* env) {
  if (env != nullptr) return env->batch->output_arrays().now().size();
  refuse_null("env");
  return 0;
}

engram_status engram_output_at(engram_env* env, size_t index, engram_array* array) {
  if (array == nullptr) return refuse_null("array");
  return with_call(env, [&](CallGuard&) {
    const std::vector<OutputArray>& outputs = env->batch->output_arrays().now();
    if (index >= outputs.size()) {
      throw Error(Error::kInvalidArgument, "output " + std::to_string(index) + " given, 0 to " +
                                               std::to_string(outputs.size() - 1) + " allowed");
    }
    *array = engram::c::to_array(outputs[index]);
  });
}

engram_status engram_write_outputs(engram_env* env, const engram_output_target* targets,
                                   size_t turns, size_t count) {
  if (targets == nullptr && turns > 0 && count > 0) return refuse_null("targets");
  return with_env(
      env, [&](engram_env& of) { of.batch->write_to(engram::c::to_turns(targets, turns, count)); });
}

int32_t engram_output_buffer(const engram_env* env) {
  return constant(env, 0, [](const engram_env& of) { return of.batch->output_arrays().buffer(); });
}

engram_status engram_instruction(engram_env* env, int32_t index, char* text, size_t capacity,
                                 size_t* length) {
  if (text == nullptr && capacity > 0) return refuse_null("text");
  return with_env(env, [&](engram_env& of) {
    give_text(of.queries.instruction(index), text, capacity, length);
  });
}

engram_status engram_render(engram_env* env, int32_t index, const char* camera, int32_t width,
                            int32_t height, uint8_t* rgb, size_t size) {
  if (camera == nullptr) return refuse_null("camera");
  if (rgb == nullptr) return refuse_null("rgb");
  return with_env(env, [&](engram_env& of) {
    of.renderer.render(index, camera, width, height, {rgb, size});
  });
}

// ---- queries ----

int32_t engram_drawn_dim(const engram_env* env) {
  return constant(env, 0, [](const engram_env& of) { return of.queries.sampled_dim(); });
}

engram_status engram_drawn(engram_env* env, float* values, size_t count) {
  if (values == nullptr && count > 0) return refuse_null("values");
  return with_env(env, [&](engram_env& of) { of.queries.sampled_values({values, count}); });
}

// ---- snapshots ----

engram_status engram_save(engram_env* env, int32_t index, void* bytes, size_t capacity,
                          size_t* size) {
  if (bytes == nullptr && capacity > 0) return refuse_null("bytes");
  if (size == nullptr) return refuse_null("size");
  return with_env(env, [&](engram_env& of) {
    const bool whole = index == ENGRAM_WHOLE_BATCH;
    *size = whole ? of.snapshotter.save_size() : of.snapshotter.save_size(index);
    if (capacity == 0) return;
    if (capacity < *size) {
      throw Error(Error::kInvalidArgument, "snapshot: room for " + std::to_string(capacity) +
                                               " bytes given, " + std::to_string(*size) +
                                               " needed");
    }
    const std::vector<std::byte> saved = whole ? of.snapshotter.save() : of.snapshotter.save(index);
    std::memcpy(bytes, saved.data(), saved.size());
  });
}

engram_status engram_restore(engram_env* env, int32_t index, const void* bytes, size_t size) {
  if (bytes == nullptr) return refuse_null("bytes");
  return with_env(env, [&](engram_env& of) {
    const std::span<const std::byte> saved(static_cast<const std::byte*>(bytes), size);
    if (index == ENGRAM_WHOLE_BATCH) {
      of.snapshotter.restore(saved);
    } else {
      of.snapshotter.restore(index, saved);
    }
  });
}
