// Touches and dense rewards of BunchOfColors, SeqOfColors and ChainOfColors (docs/tasks/colors.md).
#pragma once

#include <cstdint>
#include <span>

#include "tasks/common/action_cost.h"

namespace engram::tasks {

// Judgement of a family: by the set of touched colours, or by their order too. kSeqStrict is
// upstream's code for Seq, which asks for the order as well.
enum class ColorRule { kBunch, kSeq, kSeqStrict, kChain };

struct TouchTally {
  int correct = 0;  // Chain: in the place of the cue
  int wrong = 0;
  int touched = 0;
  bool all_touched = false;  // exactly the colours of the cue
  bool no_extra = true;
  bool order_ok = true;
  bool mistaken = false;  // a touch was wrong, or out of order where that counts
  int next = -1;          // colour to touch next, -1: none

  bool complete() const { return all_touched && no_extra && order_ok; }
};

// targets: colours of the cue, in its order. touched: a flag per colour. order: colours in the
// order of their first touches, then -1; as long as targets, read for kSeqStrict and kChain only.
TouchTally tally_touches(ColorRule rule, std::span<const std::int32_t> targets,
                         std::span<const std::uint8_t> touched, const std::int32_t* order);

// The number of an answer: a digit per touch in their order, 1 for colour 0. order: of that many
// touches at most, -1 where there is none yet.
int answer_number(const std::int32_t* order, int length);

// Reward of touches: how near the next target is, how still the arm, and how many touches are
// right.
struct ColorTouchRewardInputs {
  double goal_distance = 0;  // m
  double arm_speed = 0;      // norm of the arm joint velocities, rad/s
  TouchTally tally;
  int length = 1;  // colours in the cue
  bool acting = false;
  bool success = false;
  bool robot_static = false;  // for reward_dict alone
};

struct ColorTouchRewardTerms {
  double reaching = 0;
  double reward = 0;  // whatever the phase, and without success
};

ColorTouchRewardTerms color_touch_terms(const ColorTouchRewardInputs& in);

// The terms of info "reward_dict", name beside value.
template <class Visitor>
void list_color_touch_terms(Visitor& row, ColorRule rule, const ColorTouchRewardInputs& in,
                            const ColorTouchRewardTerms& terms) {
  const bool ordered = rule == ColorRule::kChain;
  row.term("reaching_reward", "", terms.reaching);
  row.term(ordered ? "correct_touches_in_order" : "correct_touches", "", in.tally.correct);
  row.term("wrong_touches", "", in.tally.wrong);
  row.term("is_robot_static", "", in.robot_static);
  row.term("touched_cubes", "", in.tally.touched);
  row.term("sequence_cubes_mask", "", in.length);
  row.term("all_seq_touched", "", in.tally.all_touched);
  row.term("no_extra_touched", "", in.tally.no_extra);
}

// --- the VLA tasks: moving cubes costs something ---

inline constexpr double kColorSuccessReward = 400;
inline constexpr double CUBE_DISPLACEMENT_PENALTY_COEF = 20.0;

struct ColorRewardInputs {
  ColorTouchRewardInputs touches;
  ActionCost action_cost;
  double mean_displacement = 0;  // of the cubes, m
  // For reward_dict alone.
  double max_displacement = 0;  // of the cubes, m
  bool displaced = false;       // a cube is too far from where it appeared
};

struct ColorRewardTerms {
  ColorTouchRewardTerms touches;
  SmoothnessTerms smooth;
  double displacement_penalty = 0;
  double reward = 0;
};

ColorRewardTerms color_reward(const ColorRewardInputs& in, const SmoothnessParams& params);

// The terms of info "reward_dict" after those of list_color_touch_terms.
template <class Visitor>
void list_color_terms(Visitor& row, const ColorRewardInputs& in, const ColorRewardTerms& terms) {
  list_smoothness(row, terms.smooth);
  row.term("smooth_penalty", "", terms.smooth.penalty);
  row.term("mean_cube_displacement_xy", "m", in.mean_displacement);
  row.term("max_cube_displacement_xy", "m", in.max_displacement);
  row.term("cube_displacement_penalty", "", terms.displacement_penalty);
  row.term("strong_cube_displacement", "", in.displaced);
}

// --- the RL tasks ---

inline constexpr double kColorTouchSuccessReward = 100;

// The dense reward; terms: of color_touch_terms.
double color_touch_reward(const ColorTouchRewardInputs& in, const ColorTouchRewardTerms& terms);

}  // namespace engram::tasks
