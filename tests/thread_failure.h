// Threads that the system refuses, on demand.
#pragma once

namespace engram::test {

// While one lives, the start of a thread fails: that of this number, 1 being the next one.
class FailingThread {
 public:
  explicit FailingThread(int number) noexcept;
  ~FailingThread();
  FailingThread(const FailingThread&) = delete;
  FailingThread& operator=(const FailingThread&) = delete;
};

}  // namespace engram::test
