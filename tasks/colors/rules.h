// What touches are worth in BunchOfColors, SeqOfColors and ChainOfColors (buttons 4.6 to 4.10).
#pragma once

#include <cstdint>
#include <span>

#include "tasks/parts/smoothness.h"

namespace engram::tasks {

// How the families judge: by the set of touched colours, or by their order too. kSeqStrict is
// upstream's code for Seq, which asks for the order as well (buttons 9, C1).
enum class ColorRule { kBunch, kSeq, kSeqStrict, kChain };

struct TouchTally {
  int correct = 0;  // Chain: in the place of the cue
  int wrong = 0;
  int touched = 0;
  bool all_touched = false;  // exactly the colours of the cue
  bool no_extra = true;
  bool order_ok = true;
  int next = -1;  // colour to touch next, -1: none

  bool complete() const { return all_touched && no_extra && order_ok; }
};

// targets: colours of the cue, in its order. touched: a flag per colour. order: colours in the
// order of their first touches, then -1; as long as targets, read for kSeqStrict and kChain only.
TouchTally tally_touches(ColorRule rule, std::span<const std::int32_t> targets,
                         std::span<const std::uint8_t> touched, const std::int32_t* order);

inline constexpr double kColorSuccessReward = 400;
inline constexpr double CUBE_DISPLACEMENT_PENALTY_COEF = 20.0;

struct ColorRewardInputs {
  double goal_distance = 0;  // m
  Haste haste;
  int correct = 0;
  int wrong = 0;
  int length = 1;                // colours in the cue
  double mean_displacement = 0;  // of the cubes, m
  bool acting = false;
  bool success = false;
};

struct ColorRewardTerms {
  double reaching = 0;
  SmoothnessTerms smooth;
  double displacement_penalty = 0;
  double reward = 0;
};

ColorRewardTerms color_reward(const ColorRewardInputs& inputs, const SmoothnessParams& params);

}  // namespace engram::tasks
