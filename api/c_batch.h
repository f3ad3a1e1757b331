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
#include "core/env/queries.h"
#include "core/env/scene_renderer.h"
#include "core/env/snapshot.h"
#include "engram/engram_c.h"
#include "protocol/batch/make.h"

namespace engram::c {

// State of a handle. Calls are refused unless it is kIdle.
enum class Use : int {
  kIdle,
  kBusy,      // a call is at work
  kStepping,  // between step_async and step_wait
};

// The outputs of a batch as arrays of the C API, in the order of engram_output_at.
std::vector<engram_array> list_outputs(const Batch& env);
// Those that final outputs have; empty unless the batch keeps any.
std::vector<engram_array> list_final_outputs(const Batch& env);

}  // namespace engram::c

// NOLINTNEXTLINE(readability-identifier-naming): the name is of the C API
struct engram_env {
  explicit engram_env(std::unique_ptr<engram::Batch> made);

  std::unique_ptr<engram::Batch> batch;
  engram::Queries queries;
  engram::SceneRenderer renderer;
  engram::Snapshotter snapshotter;
  std::vector<float> actions;         // of the step under way
  std::vector<engram_array> outputs;  // their names and memory are the batch's
  std::vector<engram_array> final_outputs;
  std::string description;                        // from the first call for it on
  std::unique_ptr<engram::c::StepDriver> driver;  // from the first step_async on
  std::atomic<engram::c::Use> use = engram::c::Use::kIdle;
  const pid_t owner = ::getpid();

  // A copy of the caller's actions, which other threads may write to while a step checks and uses
  // them. Those of a wrong length are returned as they are: no step takes them.
  std::span<const float> copied(std::span<const float> given);

  // A forked process has the batch's memory, but none of its threads: steps would wait for ever.
  bool forked() const noexcept { return ::getpid() != owner; }
};

namespace engram::c {

// Claims a handle for one call.
class Claim {
 public:
  // `from`: the use that the call expects.
  explicit Claim(engram_env& env, Use from = Use::kIdle) noexcept
      : env_(env), found_(from), claimed_(env.use.compare_exchange_strong(found_, Use::kBusy)) {}
  ~Claim() {
    if (claimed_) env_.use.store(leave_);
  }
  Claim(const Claim&) = delete;
  Claim& operator=(const Claim&) = delete;

  bool claimed() const noexcept { return claimed_; }
  Use found() const noexcept { return found_; }
  // The use that this call leaves behind; kIdle unless said otherwise.
  void leave(Use use) noexcept { leave_ = use; }

 private:
  engram_env& env_;
  Use found_;
  Use leave_ = Use::kIdle;
  bool claimed_;
};

engram_status refuse_null(const char* what) noexcept;
engram_status refuse_busy(Use found) noexcept;
engram_status refuse_forked(const engram_env& env) noexcept;

// Runs f(claim) while no other call can use the handle.
template <class F>
engram_status with_claim(engram_env* env, F&& f) noexcept {
  if (env == nullptr) return refuse_null("env");
  if (env->forked()) return refuse_forked(*env);
  Claim claim(*env);
  if (!claim.claimed()) return refuse_busy(claim.found());
  return guarded([&] { f(claim); });
}

// The same for calls that leave the handle idle.
template <class F>
engram_status with_env(engram_env* env, F&& f) noexcept {
  return with_claim(env, [&](Claim&) { f(*env); });
}

}  // namespace engram::c
