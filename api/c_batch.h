// The object behind a handle of the C API.
#pragma once

#include <sys/types.h>
#include <unistd.h>

#include <atomic>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "api/c_error.h"
#include "api/step_driver.h"
#include "core/batch/queries.h"
#include "core/batch/scene_renderer.h"
#include "core/batch/snapshot.h"
#include "engram/engram_c.h"
#include "protocol/make/make.h"

namespace engram::c {

// State of a handle. Calls are refused unless it is kIdle.
enum class CallState : int {
  kIdle,
  kBusy,      // a call is at work
  kStepping,  // between step_async and step_wait
};

// An engram_dtype.
std::int32_t dtype_of(DType type);

// An output as an array of the C API; its texts and memory are the batch's.
engram_array to_array(const OutputArray& output);

}  // namespace engram::c

// NOLINTNEXTLINE(readability-identifier-naming): the name is of the C API
struct engram_env {
  explicit engram_env(std::unique_ptr<engram::Batch> made);

  std::unique_ptr<engram::Batch> batch;
  engram::Queries queries;
  engram::SceneRenderer renderer;
  engram::Snapshotter snapshotter;
  std::vector<float> actions;                     // of the step under way
  std::string description;                        // from the first call for it on
  std::unique_ptr<engram::c::StepDriver> driver;  // from the first step_async on
  std::atomic<engram::c::CallState> use = engram::c::CallState::kIdle;
  const pid_t owner = ::getpid();

  // A copy of the caller's actions, which other threads may write to while a step checks and uses
  // them. Those of a wrong length are returned as they are: no step takes them.
  std::span<const float> copied(std::span<const float> given);

  // A forked process has the batch's memory, but none of its threads: steps would wait for ever.
  bool forked() const noexcept { return ::getpid() != owner; }
};

namespace engram::c {

// Claims a handle for one call.
class CallGuard {
 public:
  // `from`: the use that the call expects.
  explicit CallGuard(engram_env& env, CallState from = CallState::kIdle) noexcept
      : env_(env),
        found_(from),
        acquired_(env.use.compare_exchange_strong(found_, CallState::kBusy)) {}
  ~CallGuard() {
    if (acquired_) env_.use.store(leave_);
  }
  CallGuard(const CallGuard&) = delete;
  CallGuard& operator=(const CallGuard&) = delete;

  bool acquired() const noexcept { return acquired_; }
  CallState found() const noexcept { return found_; }
  // The use that this call leaves behind; kIdle unless said otherwise.
  void leave(CallState use) noexcept { leave_ = use; }

 private:
  engram_env& env_;
  CallState found_;
  CallState leave_ = CallState::kIdle;
  bool acquired_;
};

engram_status refuse_null(const char* what) noexcept;
engram_status refuse_busy(CallState found) noexcept;
engram_status refuse_forked(const engram_env& env) noexcept;

// Runs f(claim) while no other call can use the handle.
template <class F>
engram_status with_call(engram_env* env, F&& f) noexcept {
  if (env == nullptr) return refuse_null("env");
  if (env->forked()) return refuse_forked(*env);
  CallGuard call(*env);
  if (!call.acquired()) return refuse_busy(call.found());
  return guarded([&] { f(call); });
}

// Runs a call that leaves the handle idle.
template <class F>
engram_status with_env(engram_env* env, F&& f) noexcept {
  return with_call(env, [&](CallGuard&) { f(*env); });
}

}  // namespace engram::c
