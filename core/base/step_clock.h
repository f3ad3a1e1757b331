// Profile of control steps: time per part. Tools attach a clock to a batch; without one, a mark is
// a test of a null pointer.
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <string_view>
#include <vector>

namespace engram {

enum class StepPart {
  kController,   // joint targets from the action, and the drives' forces in every substep
  kDynamics,     // contacts, dynamics and the solver in every substep
  kWake,         // waking and sleeping of props
  kGather,       // columns to the workspace and back, checks for diverged states
  kTask,         // phases, success, rewards, endings
  kObservation,  // TCP pose, proprioception, state vector
  kReset,        // new episodes
  kRender,       // images
};
inline constexpr int kStepParts = 8;
inline constexpr std::array<std::string_view, kStepParts> kStepPartNames = {
    "controller", "dynamics", "wake", "gather", "task", "observation", "reset", "render"};

class StepClock {
 public:
  using Ticks = std::array<std::uint64_t, kStepParts>;

  // Times of one worker, on cache lines of its own.
  class alignas(64) Worker {
   public:
    // Begins to count time.
    void start() { last_ = now(); }
    // Adds the time since the last call to that part.
    void mark(StepPart part) {
      const std::uint64_t time = now();
      ticks_[static_cast<std::size_t>(part)] += time - last_;
      ++marks_[static_cast<std::size_t>(part)];
      last_ = time;
    }
    const Ticks& ticks() const { return ticks_; }
    // Number of marks per part. A mark itself takes time, which is counted too.
    const Ticks& marks() const { return marks_; }

   private:
    std::uint64_t last_ = 0;
    Ticks ticks_{};
    Ticks marks_{};
  };

  // workers: number of the batch's threads.
  explicit StepClock(int workers) : workers_(static_cast<std::size_t>(workers)) {}

  Worker& worker(int index) { return workers_[static_cast<std::size_t>(index)]; }

  // Sums over all workers since construction.
  Ticks ticks() const { return sum(&Worker::ticks); }
  Ticks marks() const { return sum(&Worker::marks); }

  // Ticks of a clock that runs evenly and takes a few nanoseconds to read.
  static std::uint64_t now() {
#ifdef __x86_64__
    return __builtin_ia32_rdtsc();  // <x86intrin.h> would take half a second to compile
#else
    return static_cast<std::uint64_t>(std::chrono::steady_clock::now().time_since_epoch().count());
#endif
  }

 private:
  Ticks sum(const Ticks& (Worker::*counts)() const) const {
    Ticks total{};
    for (const Worker& worker : workers_) {
      for (std::size_t part = 0; part < kStepParts; ++part) total[part] += (worker.*counts)()[part];
    }
    return total;
  }

  std::vector<Worker> workers_;
};

inline void mark(StepClock::Worker* clock, StepPart part) {
  if (clock != nullptr) clock->mark(part);
}

}  // namespace engram
