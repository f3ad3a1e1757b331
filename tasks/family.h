// A family of tasks, as it stands in the registry: facts of its ids for a benchmark, the function
// that makes them, and the expectations of tests. Defined in the family's own file.
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <span>
#include <string_view>

#include "core/base/constant.h"

namespace engram {

class Task;            // core/task/task.h
struct RegistryEntry;  // tasks/registry.h

// Parts of the benchmark. The VLA tasks by length of an episode: up to 200 control steps, up to
// 601, and more; those outside the canonical list, and users' own, are kExtended, whatever their
// length. The RL tasks are one part.
enum class Split { kShort, kMedium, kLong, kExtended, kRl };

// "short", "medium", "long", "extended" or "rl".
std::string_view split_name(Split split) noexcept;

// One task of a family.
struct TaskSpec {
  std::string_view id;  // "RememberColor9-VLA-v0"
  int horizon = 0;      // control steps
  Split split = Split::kShort;
  double oracle_floor = 0.95;         // least share of episodes that the oracle solves
  std::string_view instruction = {};  // where it is not the family's
  std::string_view memory_type = {};  // likewise

  constexpr bool is_rl() const { return split == Split::kRl; }
};

// Facts that hold for every task of a family; tests check them.
struct Expectations {
  // Normalised dense reward of a step without success (docs/tasks/README.md).
  double min_reward = 0;
  double max_reward = 0;
  bool moves_untouched = false;  // props are simulated although the robot has not touched them
  // Props sink a little while they are simulated: not those that the task puts back or moves.
  bool settles = true;
  bool goal_for_people = false;  // the human view shows the goal, and so may reveal what was hidden
  bool hides = false;            // props are hidden at some time
};

// A change of an episode's past that changes neither its question nor its answer.
enum class CounterfactualChange {
  kStart,       // the arm has started elsewhere; the question comes in the scene of the other past
  kDraw,        // another value of a draw; where it makes the cue longer, the delay gets shorter
  kOrder,       // the hidden values in reverse
  kSameAnswer,  // other hidden values with the same answer
};

// What a scene leaves of an answer that is right by another past: answers end at their first wrong
// part.
enum class AnswerCut {
  kNone,    // an answer has one part
  kDigits,  // a digit for each part, in order
  kCount,   // as many as there have been parts
};

// What probes of memory (docs/probe.md) have to know of a family. What an episode hides is
// TaskInfo::hidden_variable.
struct MemoryFacts {
  // Why no two episodes of one present differ in what their past asks for; empty: they do.
  std::string_view no_counterfactuals = {};
  std::string_view hidden = {};  // the draw that pasts differ in, where the task names none
  // The cue is what the robot works with: the hand of the task's choices works until it needs the
  // answer, and the question comes then. It ends nearly where it would have from another past, so
  // presents are the same in scenes that are exchanged. Episodes are as long as two, for both.
  bool cue_by_hand = false;
  bool any_order = false;  // the order of the hidden values is no part of the answer
  AnswerCut answer_cut = AnswerCut::kNone;
  // kStart takes its place where the task's constants leave it nothing to change.
  CounterfactualChange irrelevant = CounterfactualChange::kStart;
  std::string_view irrelevant_draw = {};  // of kDraw
  std::string_view delay = {};  // range constant of the time from cue to question; empty: none
  std::string_view items = {};  // constant or draw of how much there is to remember; empty: none
};

struct Family {
  std::string_view name;         // "RememberColor"
  std::string_view memory_type;  // "Object"
  // In English; "{angle_deg}" stands for a number of the episode. Empty where tasks have their own.
  std::string_view instruction = {};
  std::span<const TaskSpec> tasks;  // in the benchmark's order
  // constants: all that differ from the task's own, the entry's included.
  std::unique_ptr<Task> (*make)(const RegistryEntry& entry, const ConstantTable& constants);
  Expectations expectations = {};
  MemoryFacts memory = {};
};

// The rows of a family's table of parameters, each of which has a TaskSpec `task`.
template <class Params, std::size_t Count>
constexpr std::array<TaskSpec, Count> rows_of(const std::array<Params, Count>& variants) {
  std::array<TaskSpec, Count> rows;
  for (std::size_t i = 0; i < Count; ++i) rows[i] = variants[i].task;
  return rows;
}

}  // namespace engram
