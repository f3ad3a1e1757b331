// Default IEEE 754 arithmetic, whatever mode the host program has set.
#pragma once

#if defined(__SSE__)
#include <xmmintrin.h>

#include <cstdint>
#else
#include <cfenv>
#endif

namespace engram {

// RAII guard: while it lives, its thread rounds to nearest, keeps subnormal numbers and traps
// nothing. Its end restores the thread's mode, exception flags included. Around a callback it
// undoes what the callback sets.
class IeeeScope {
 public:
#if defined(__SSE__)
  IeeeScope() noexcept : sse_(_mm_getcsr()), x87_(x87_control()) {
    constexpr unsigned kFlags = 0x003f;    // exceptions that have occurred
    constexpr unsigned kDefault = 0x1f80;  // exceptions masked
    if ((sse_ & ~kFlags) != kDefault) _mm_setcsr(kDefault);
    set_x87_control(kX87Default);
  }
  ~IeeeScope() {
    _mm_setcsr(sse_);
    set_x87_control(x87_);
  }
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
  // glibc's strtod and printf round as the x87 unit does, which has a mode of its own.
  static constexpr std::uint16_t kX87Default = 0x037f;  // 64 bits of mantissa, exceptions masked

  static std::uint16_t x87_control() noexcept {
    std::uint16_t control = 0;
    asm volatile("fnstcw %0" : "=m"(control));
    return control;
  }

  // Clears the unit's exception flags: one that a new mode traps would fault at once.
  static void set_x87_control(std::uint16_t control) noexcept {
    if (x87_control() == control) return;
    asm volatile("fnclex\n\tfldcw %0" : : "m"(control));
  }

  unsigned sse_;
  std::uint16_t x87_;
#else
  std::fenv_t before_{};
#endif
};

}  // namespace engram
