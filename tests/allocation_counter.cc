#include "tests/allocation_counter.h"

#include <mujoco/mujoco.h>

#include <atomic>
#include <cstdlib>
#include <new>

#include "tests/sanitizers.h"

namespace {

using engram::test::ForgivenLeaks;

std::atomic<std::int64_t> allocations = 0;
std::atomic<std::int64_t> outstanding = 0;
std::atomic<std::int64_t> until_failure = 0;  // 0: none will fail

bool fails() noexcept {
  if (until_failure.load(std::memory_order_relaxed) <= 0) return false;
  return until_failure.fetch_sub(1) == 1;
}

void* allocate(std::size_t size, std::size_t alignment) {
  allocations.fetch_add(1, std::memory_order_relaxed);
  // aligned_alloc wants a whole number of alignments.
  const std::size_t rounded = (size + alignment - 1) / alignment * alignment;
  if (rounded < size || fails()) throw std::bad_alloc();
  void* memory = std::aligned_alloc(alignment, rounded == 0 ? alignment : rounded);
  if (memory == nullptr) throw std::bad_alloc();
  outstanding.fetch_add(1, std::memory_order_relaxed);
  return ForgivenLeaks::pass(memory);
}

void release(void* memory) noexcept {
  if (memory != nullptr) outstanding.fetch_sub(1, std::memory_order_relaxed);
  std::free(memory);
}

void* allocate_for_mujoco(std::size_t size) {
  if (fails()) return nullptr;
  outstanding.fetch_add(1, std::memory_order_relaxed);
  return ForgivenLeaks::pass(std::aligned_alloc(64, (size + 63) / 64 * 64));
}

constexpr std::size_t kDefaultAlignment = __STDCPP_DEFAULT_NEW_ALIGNMENT__;

}  // namespace

namespace engram::test {

std::int64_t allocation_count() noexcept { return allocations.load(); }
std::int64_t outstanding_allocations() noexcept { return outstanding.load(); }

MujocoMemory::MujocoMemory() noexcept {
  mju_user_malloc = allocate_for_mujoco;
  mju_user_free = release;
}
MujocoMemory::~MujocoMemory() {
  mju_user_malloc = nullptr;
  mju_user_free = nullptr;
}

FailingAllocation::FailingAllocation(std::int64_t number) noexcept { until_failure = number; }
FailingAllocation::~FailingAllocation() { until_failure = 0; }
bool FailingAllocation::happened() noexcept { return until_failure.load() <= 0; }

}  // namespace engram::test

// All forms that sanitizers replace too, so that each pair stays matched.
void* operator new(std::size_t size) { return allocate(size, kDefaultAlignment); }
void* operator new[](std::size_t size) { return allocate(size, kDefaultAlignment); }
void* operator new(std::size_t size, std::align_val_t alignment) {
  return allocate(size, static_cast<std::size_t>(alignment));
}
void* operator new[](std::size_t size, std::align_val_t alignment) {
  return allocate(size, static_cast<std::size_t>(alignment));
}
void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  try {
    return allocate(size, kDefaultAlignment);
  } catch (const std::bad_alloc&) {
    return nullptr;
  }
}
void* operator new[](std::size_t size, const std::nothrow_t& tag) noexcept {
  return operator new(size, tag);
}
void operator delete(void* memory) noexcept { release(memory); }
void operator delete[](void* memory) noexcept { release(memory); }
void operator delete(void* memory, std::size_t) noexcept { release(memory); }
void operator delete[](void* memory, std::size_t) noexcept { release(memory); }
void operator delete(void* memory, std::align_val_t) noexcept { release(memory); }
void operator delete[](void* memory, std::align_val_t) noexcept { release(memory); }
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept { release(memory); }
void operator delete[](void* memory, std::size_t, std::align_val_t) noexcept { release(memory); }
void operator delete(void* memory, const std::nothrow_t&) noexcept { release(memory); }
void operator delete[](void* memory, const std::nothrow_t&) noexcept { release(memory); }
