// What tests expect of a family, where it is not what most families do.
#pragma once

#include <array>
#include <string>
#include <string_view>

namespace engram::test {

struct FamilyTraits {
  std::string_view ids = {};  // what the ids begin with
  double oracle = 0.95;       // least share of episodes that the oracle solves
  // Props are simulated although nobody has touched them.
  bool moves_untouched = false;
  // Props sink a little while they are simulated: not those that the task puts back or moves.
  bool settles = true;
  // The human view may tell what was hidden: it shows the goal.
  bool goal_for_people = false;
  // Props are hidden at some time.
  bool hides = false;
};

// The first row that fits an id counts.
inline constexpr std::array kFamilyTraits = {
    FamilyTraits{.ids = "Remember", .hides = true},
    FamilyTraits{.ids = "FindImposter", .moves_untouched = true, .hides = true},
    // Outside the benchmark; its grasp leaves no step to spare.
    FamilyTraits{.ids = "ShellGamePick", .oracle = 0.90, .goal_for_people = true, .hides = true},
    FamilyTraits{.ids = "ShellGamePush", .goal_for_people = true, .hides = true},
    FamilyTraits{.ids = "ShellGameTouch", .hides = true},
    FamilyTraits{.ids = "ShellGame", .settles = false, .hides = true},
    FamilyTraits{.ids = "BunchOfColors", .hides = true},
    FamilyTraits{.ids = "SeqOfColors", .hides = true},
    FamilyTraits{.ids = "ChainOfColors", .hides = true},
    FamilyTraits{.ids = "TakeItBack", .hides = true},
    FamilyTraits{.ids = "BlinkCount", .settles = false},
    // Balls roll off, and get faster than the hand can follow.
    FamilyTraits{.ids = "InterceptSlow", .moves_untouched = true, .settles = false},
    FamilyTraits{
        .ids = "InterceptMedium", .oracle = 0.90, .moves_untouched = true, .settles = false},
    FamilyTraits{.ids = "InterceptFast", .oracle = 0.85, .moves_untouched = true, .settles = false},
    FamilyTraits{
        .ids = "InterceptGrabSlow", .oracle = 0.90, .moves_untouched = true, .settles = false},
    FamilyTraits{
        .ids = "InterceptGrabMedium", .oracle = 0.80, .moves_untouched = true, .settles = false},
    FamilyTraits{
        .ids = "InterceptGrabFast", .oracle = 0.70, .moves_untouched = true, .settles = false},
    FamilyTraits{.ids = "TraceShapeSeq", .oracle = 0.90},
    FamilyTraits{.ids = "BatteriesCheckerEasy", .oracle = 0.90},
    FamilyTraits{.ids = "BatteriesCheckerHard-3", .oracle = 0.85},
    FamilyTraits{.ids = "BatteriesCheckerHard-6", .oracle = 0.85},
    FamilyTraits{.ids = "BatteriesCheckerHard", .oracle = 0.75},
    FamilyTraits{},
};

inline const FamilyTraits& traits_of(const std::string& id) {
  for (const FamilyTraits& traits : kFamilyTraits) {
    if (id.starts_with(traits.ids)) return traits;
  }
  return kFamilyTraits.back();
}

}  // namespace engram::test
