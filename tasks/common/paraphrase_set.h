// Wordings of the benchmark's instructions, written by hand. {angle_deg} and {steps} stand for a
// number of the episode.
#pragma once

#include <array>
#include <string_view>

namespace engram {

inline constexpr int kParaphrases = 10;  // of every instruction

struct ParaphraseSet {
  std::string_view instruction;
  std::array<std::string_view, kParaphrases> others;
};

}  // namespace engram
