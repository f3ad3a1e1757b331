// What tests must know of sanitizers.
#pragma once

#include <atomic>
#include <cstddef>

#if defined(__SANITIZE_ADDRESS__)  // GCC
#define ENGRAM_ADDRESS_SANITIZER
#elif defined(__SANITIZE_THREAD__)
#define ENGRAM_THREAD_SANITIZER
#elif defined(__has_feature)  // Clang
#if __has_feature(address_sanitizer)
#define ENGRAM_ADDRESS_SANITIZER
#elif __has_feature(thread_sanitizer)
#define ENGRAM_THREAD_SANITIZER
#endif
#endif

#ifdef ENGRAM_ADDRESS_SANITIZER
#include <sanitizer/lsan_interface.h>
#endif

#ifdef ENGRAM_THREAD_SANITIZER
// NOLINTNEXTLINE(readability-identifier-naming): the runtime's
extern "C" void AnnotateBenignRaceSized(const char* file, int line, const volatile void* memory,
                                        long size, const char* description);
#endif

namespace engram::test {

// With a heap of its own, which keeps what is freed.
#if defined(ENGRAM_ADDRESS_SANITIZER) || defined(ENGRAM_THREAD_SANITIZER)
inline constexpr bool kSanitized = true;
#else
inline constexpr bool kSanitized = false;
#endif

// In front of commands that run under a limit of file sizes. Clang's thread sanitizer makes a file
// in the temporary folder, if there is one, and crashes when it is cut short.
inline constexpr const char* kNoTemporaryFolder = "TMPDIR=/nonexistent ";

// Races on this memory are what a test is about: a caller that writes where engram reads.
inline void allow_races([[maybe_unused]] const volatile void* memory,
                        [[maybe_unused]] std::size_t size) {
#ifdef ENGRAM_THREAD_SANITIZER
  AnnotateBenignRaceSized(__FILE__, __LINE__, memory, static_cast<long>(size), "meant");
#endif
}

// While one lives, nothing that is allocated counts as a leak: for what other libraries lose. On
// other threads that holds for what goes through allocation_counter.cc.
class [[maybe_unused]] ForgivenLeaks {
 public:
#ifdef ENGRAM_ADDRESS_SANITIZER
  ForgivenLeaks() {
    ++alive_;
    __lsan_disable();
  }
  ~ForgivenLeaks() {
    __lsan_enable();
    --alive_;
  }
  // A new object, which is not counted if one lives.
  static void* pass(void* memory) noexcept {
    if (alive_ > 0 && memory != nullptr) __lsan_ignore_object(memory);
    return memory;
  }
#else
  ForgivenLeaks() = default;
  ~ForgivenLeaks() = default;
  static void* pass(void* memory) noexcept { return memory; }
#endif
  ForgivenLeaks(const ForgivenLeaks&) = delete;
  ForgivenLeaks& operator=(const ForgivenLeaks&) = delete;

#ifdef ENGRAM_ADDRESS_SANITIZER
 private:
  static inline std::atomic<int> alive_ = 0;
#endif
};

}  // namespace engram::test
