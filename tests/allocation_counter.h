// Counts the allocations that C++ code makes, for tests of what must not allocate.
#pragma once

#include <cstdint>

namespace engram::test {

// Calls of operator new by all threads since the program started.
std::int64_t allocation_count() noexcept;
// What they, and MuJoCo while a MujocoMemory lives, have taken and not given back.
std::int64_t outstanding_allocations() noexcept;

// MuJoCo's own allocations count too while one lives. All of its objects that are made meanwhile
// must be gone by the end.
class MujocoMemory {
 public:
  MujocoMemory() noexcept;
  ~MujocoMemory();
  MujocoMemory(const MujocoMemory&) = delete;
  MujocoMemory& operator=(const MujocoMemory&) = delete;
};

// While one lives, an allocation fails: that of this number, 1 being the next one.
class FailingAllocation {
 public:
  explicit FailingAllocation(std::int64_t number) noexcept;
  ~FailingAllocation();
  FailingAllocation(const FailingAllocation&) = delete;
  FailingAllocation& operator=(const FailingAllocation&) = delete;

  // Whether there were that many.
  static bool happened() noexcept;
};

}  // namespace engram::test
