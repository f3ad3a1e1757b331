// Modes of arithmetic that a host program may have set for its threads.
#pragma once

#if defined(__SSE__)

#include <xmmintrin.h>

#include <cstdint>
#include <vector>

namespace engram::test {

struct HostMode {
  unsigned sse = 0x1f80;       // MXCSR
  std::uint16_t x87 = 0x037f;  // control word
  bool operator==(const HostMode&) const = default;

  // Without the flags of exceptions that have occurred.
  HostMode control() const { return {sse & ~0x3fU, x87}; }

  static HostMode current() {
    HostMode mode{_mm_getcsr(), 0};
    asm volatile("fnstcw %0" : "=m"(mode.x87));
    return mode;
  }
  void set() const {
    _mm_setcsr(sse);
    asm volatile("fldcw %0" : : "m"(x87));
  }
};

// 40 modes: each rounding, by one or both of the processor's units, with numbers flushed to zero,
// x87 precision reduced and exceptions trapped, one by one and together.
inline std::vector<HostMode> host_modes() {
  constexpr unsigned kFlushToZero = 0x8000;
  constexpr unsigned kDenormalsAreZero = 0x0040;
  constexpr unsigned kSseTraps = 0x0680;       // invalid, division by zero, overflow
  constexpr std::uint16_t kX87Traps = 0x000d;  // the same
  constexpr std::uint16_t kX87Double = 0x0100;
  constexpr std::uint16_t kX87Precision = 0x0300;
  std::vector<HostMode> modes;
  for (unsigned rounding = 0; rounding < 4; ++rounding) {
    const unsigned sse = 0x1f80U | rounding << 13;
    const auto x87 = static_cast<std::uint16_t>(0x037fU | rounding << 10);
    const auto without = [x87](std::uint16_t bits) {
      return static_cast<std::uint16_t>(x87 & ~bits);
    };
    modes.insert(modes.end(), {{sse, x87},
                               {sse},
                               {.x87 = x87},
                               {sse | kFlushToZero, x87},
                               {sse | kDenormalsAreZero, x87},
                               {sse | kFlushToZero | kDenormalsAreZero},
                               {sse, without(kX87Precision)},
                               {sse, without(kX87Double)},
                               {sse & ~kSseTraps, without(kX87Traps)},
                               {(sse | kFlushToZero | kDenormalsAreZero) & ~kSseTraps,
                                without(kX87Traps | kX87Precision)}});
  }
  return modes;
}

// Calls functions as a host program in that mode does; counts calls that did not leave it as it
// was.
class Host {
 public:
  explicit Host(const HostMode& mode) : mode_(mode) {}

  template <class F>
  void run(const F& f) {
    const HostMode before = HostMode::current();
    mode_.set();
    f();
    const HostMode after = HostMode::current();
    before.set();
    if (after != mode_) ++changed_;
  }
  int changed() const { return changed_; }

 private:
  HostMode mode_;
  int changed_ = 0;
};

}  // namespace engram::test

#endif
