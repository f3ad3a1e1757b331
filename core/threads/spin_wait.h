// Short waits without the system.
#pragma once

#include <chrono>
#include <cstdint>
#include <thread>

namespace engram {

inline std::int64_t now_ns() noexcept {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

inline void relax_processor() noexcept {
#if defined(__x86_64__) || defined(__i386__)
  __builtin_ia32_pause();
#elif defined(__aarch64__)
  asm volatile("yield");
#endif
}

// Polls for a limited time. Gives the processor to other threads that wait for one, so that polling
// is harmless where threads outnumber processors.
class SpinWait {
 public:
  static constexpr std::int64_t kUsual = 20'000;  // ns

  explicit SpinWait(std::int64_t limit_ns = kUsual) noexcept : limit_(limit_ns) {}

  // Pauses for an instant. False once the time is up.
  bool poll() noexcept {
    for (int i = 0; i < kPauses; ++i) relax_processor();
    if (++turns_ % kTurnsBeforeYield == 0) std::this_thread::yield();
    const std::int64_t now = now_ns();
    if (start_ == 0) start_ = now;
    return now - start_ < limit_;
  }

 private:
  static constexpr int kPauses = 8;
  static constexpr int kTurnsBeforeYield = 4;

  std::int64_t limit_;
  std::int64_t start_ = 0;
  int turns_ = 0;
};

}  // namespace engram
