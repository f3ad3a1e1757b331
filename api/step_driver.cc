#include "api/step_driver.h"

#include <algorithm>
#include <utility>

namespace engram::c {

StepDriver::StepDriver(Batch& batch)
    : batch_(batch),
      actions_(static_cast<std::size_t>(batch.num_envs()) *
               static_cast<std::size_t>(batch.action_dim())),
      thread_([this] { serve(); }) {}

StepDriver::~StepDriver() {
  {
    const std::lock_guard lock(mutex_);
    closing_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

void StepDriver::start(std::span<const float> actions) {
  if (actions.size() != actions_.span().size()) batch_.check_actions(actions);  // throws
  // The copy is checked: another thread may write to the original.
  std::copy(actions.begin(), actions.end(), actions_.begin());
  batch_.check_actions(actions_.span());
  {
    const std::lock_guard lock(mutex_);
    stepping_ = true;
  }
  changed_.notify_all();
}

void StepDriver::wait() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return !stepping_; });
  rethrow();
}

bool StepDriver::wait_for(std::chrono::nanoseconds most) {
  std::unique_lock lock(mutex_);
  if (!changed_.wait_for(lock, most, [this] { return !stepping_; })) return false;
  rethrow();
  return true;
}

void StepDriver::rethrow() {
  if (error_) std::rethrow_exception(std::exchange(error_, nullptr));
}

// The life of the thread.
void StepDriver::serve() noexcept {
  std::unique_lock lock(mutex_);
  for (;;) {
    changed_.wait(lock, [this] { return stepping_ || closing_; });
    if (!stepping_) return;
    lock.unlock();
    std::exception_ptr error;
    try {
      batch_.step(actions_.span());
    } catch (...) {
      error = std::current_exception();
    }
    lock.lock();
    error_ = error;
    stepping_ = false;
    changed_.notify_all();
  }
}

}  // namespace engram::c
