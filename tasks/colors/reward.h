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
  bool mistaken = false;  // a touch was wrong, or out of order or repeated where that counts
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

// Dense reward of the RL tasks (tasks/common/reward_dict.h): how near the next target is, how still
// the arm, and how many touches are right.
struct ColorTouchReward {
  double goal_distance = 0;  // m
  double arm_speed = 0;      // norm of the arm joint velocities, rad/s
  TouchTally tally = {};
  int length = 1;  // colours in the cue
  bool acting = false;
  bool success = false;
  bool robot_static = false;           // for reward_dict alone
  ColorRule rule = ColorRule::kBunch;  // likewise
  // Terms.
  double reaching = 0;
  double sum = 0;  // whatever the phase, and without success

  double compute();
  template <class Visitor>
  void list_terms(Visitor& row) const {
    const bool ordered = rule == ColorRule::kChain;
    row.term("reaching_reward", "", reaching);
    row.term(ordered ? "correct_touches_in_order" : "correct_touches", "", tally.correct);
    row.term("wrong_touches", "", tally.wrong);
    row.term("is_robot_static", "", robot_static);
    row.term("touched_cubes", "", tally.touched);
    row.term("sequence_cubes_mask", "", length);
    row.term("all_seq_touched", "", tally.all_touched);
    row.term("no_extra_touched", "", tally.no_extra);
  }
};

inline constexpr double kColorTouchSuccessReward = 100;
inline constexpr double kColorSuccessReward = 400;
inline constexpr double CUBE_DISPLACEMENT_PENALTY_COEF = 20.0;

// Dense reward of the VLA tasks: moving cubes costs something.
struct ColorReward {
  ColorTouchReward touches = {};
  ActionCost action_cost = {};
  double mean_displacement = 0;  // of the cubes, m
  // For reward_dict alone.
  double max_displacement = 0;  // of the cubes, m
  bool displaced = false;       // a cube is too far from where it appeared
  SmoothnessParams smoothness = {};
  // Terms.
  SmoothnessTerms smooth = {};
  double displacement_penalty = 0;

  double compute();
  template <class Visitor>
  void list_terms(Visitor& row) const {
    touches.list_terms(row);
    smooth.list_terms(row);
    row.term("mean_cube_displacement_xy", "m", mean_displacement);
    row.term("max_cube_displacement_xy", "m", max_displacement);
    row.term("cube_displacement_penalty", "", displacement_penalty);
    row.term("strong_cube_displacement", "", displaced);
  }
};

}  // namespace engram::tasks
