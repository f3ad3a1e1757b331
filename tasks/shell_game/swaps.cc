#include "tasks/shell_game/swaps.h"

#include <algorithm>
#include <numbers>

#include "core/base/index.h"
#include "core/math/real_functions.h"

namespace engram::tasks {

void Swaps::bind(ColumnStore& memory, int max_swaps, bool snap_back) {
  snap_back_ = snap_back;
  begin_ = memory.add<std::int32_t>("shuffle_begin", 1, "control steps");
  steps_ = memory.add<std::int32_t>("shuffle_steps", 1, "control steps");
  num_swaps_ = memory.add<std::int32_t>("num_swaps");
  slots_ = memory.add<std::uint8_t>("slots_after_swaps", kCups * (max_swaps + 1));
  memory.limit("num_swaps", 1, max_swaps);
  memory.limit("slots_after_swaps", 0, kCups - 1);
}

void Swaps::reset(int env, int begin, int steps, int swaps, std::span<const int> pairs) const {
  begin_[env] = begin;
  steps_[env] = steps;
  num_swaps_[env] = swaps;
  std::uint8_t* slots = slots_.row(env);
  for (int mug = 0; mug < kCups; ++mug) slots[mug] = static_cast<std::uint8_t>(mug);
  for (const int pair : pairs.first(at(swaps))) {
    const auto [first, second] = kSwapPairs[at(pair)];
    for (int mug = 0; mug < kCups; ++mug, ++slots) {
      const int slot = *slots;
      const int next = slot == first ? second : slot == second ? first : slot;
      slots[kCups] = static_cast<std::uint8_t>(next);
    }
  }
}

Eigen::Vector3d Swaps::offset(int env, int mug, int elapsed) const {
  const int swaps = num_swaps_[env];
  const int steps_per_swap = std::max(1, steps_[env] / swaps);
  const int step = std::max(0, elapsed - begin_[env]);
  const int swap = step / steps_per_swap;
  if (swap >= swaps) return {0, slot_y(slot_of(env, snap_back_ ? swaps - 1 : swaps, mug)), 0};

  const double from = slot_y(slot_of(env, swap, mug));
  const double to = slot_y(slot_of(env, swap + 1, mug));
  const double time = static_cast<double>(step % steps_per_swap) / steps_per_swap;
  const double angle = std::numbers::pi * time * time * (3 - 2 * time);
  const double middle = (from + to) / 2;
  const double half = (from - to) / 2;
  return {-half * real::sin(angle), middle + half * real::cos(angle),
          arc_height_ * real::sin(angle)};
}

}  // namespace engram::tasks
