// Default IEEE 754 arithmetic, whatever mode the host program has set.
#pragma once

#if defined(__SSE__)
#include <xmmintrin.h>
#else
#include <cfenv>
#endif

namespace engram {

// RAII guard: while it lives, its thread rounds to nearest, keeps subnormal numbers and traps
// nothing. Its end restores the thread's mode, exception flags included.
class IeeeScope {
 public:
#if defined(__SSE__)
  IeeeScope() noexcept : before_(_mm_getcsr()) {
    constexpr unsigned kFlags = 0x003f;    // exceptions that have occurred
    constexpr unsigned kDefault = 0x1f80;  // exceptions masked
    if ((before_ & ~kFlags) != kDefault) _mm_setcsr(kDefault);
  }
  ~IeeeScope() { _mm_setcsr(before_); }
#else
  IeeeScope() noexcept {
    std::fegetenv(&before_);
    std::fesetenv(FE_DFL_ENV);
  }
  ~IeeeScope() { std::fesetenv(&before_); }
#endif
  IeeeScope(const IeeeScope&) = delete;
  IeeeScope& operator=(const IeeeScope&) = delete;

 private:
#if defined(__SSE__)
  unsigned before_;
#else
  std::fenv_t before_{};
#endif
};

}  // namespace engram
