// Steps a batch in a thread of its own, so that the caller can do something else meanwhile.
#pragma once

#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <span>
#include <thread>

#include "core/base/aligned_array.h"
#include "core/batch/batch.h"

namespace engram::c {

// One step at a time: start, wait, start, wait, ... .
class StepDriver {
 public:
  // Starts the thread. Throws std::system_error if the system refuses it. `batch` must outlive this
  // object, and must not be used between start and the end of wait.
  explicit StepDriver(Batch& batch);
  // Waits for a step under way.
  ~StepDriver();
  StepDriver(const StepDriver&) = delete;
  StepDriver& operator=(const StepDriver&) = delete;

  // Throws Error, and starts nothing, for actions that Batch::step refuses. Copies them.
  void start(std::span<const float> actions);
  // Returns when the step is done; rethrows what it threw.
  void wait();
  // Waits at most that long. False: the step goes on.
  bool wait_for(std::chrono::nanoseconds most);

 private:
  void serve() noexcept;
  void rethrow();

  Batch& batch_;
  AlignedArray<float> actions_;
  std::mutex mutex_;
  std::condition_variable changed_;
  bool stepping_ = false;  // guarded by mutex_, like the two below
  bool closing_ = false;
  std::exception_ptr error_;
  std::thread thread_;
};

}  // namespace engram::c
