#include "protocol/batch/ceilings.h"

#include <algorithm>
#include <iterator>

namespace engram {
namespace {

// begin ceilings: written by scripts/memory.py
constexpr Ceiling kCeilings[] = {
    {"RememberColor3-VLA-v0", 0.33, 0.6, 1, 0.33, 0.33, 1},
};
// end ceilings

}  // namespace

const Ceiling* find_ceiling(std::string_view id) noexcept {
  const auto* const found = std::ranges::find(kCeilings, id, &Ceiling::id);
  return found == std::end(kCeilings) ? nullptr : found;
}

std::optional<double> memory_score(const Ceiling& ceiling, double success_rate) noexcept {
  constexpr double kLeastRoom = 0.05;  // below that, differences are luck
  const double room = ceiling.oracle - ceiling.sweep;
  if (room < kLeastRoom) return std::nullopt;
  return (success_rate - ceiling.sweep) / room;
}

}  // namespace engram
