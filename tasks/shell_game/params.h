// Parameters of all shell games, named as the class constants.
#pragma once

#include <array>
#include <string>

#include "core/base/error.h"
#include "mjcf/mug.h"
#include "tasks/common/constant_binder.h"
#include "tasks/common/task_options.h"
#include "tasks/family.h"

namespace engram::tasks {

inline constexpr int kCups = 3;  // slots 0 left (-y), 1 center, 2 right
inline constexpr int kMiddleSlot = 1;
inline constexpr std::array<const char*, kCups> kSlotNames = {"left", "middle", "right"};
inline constexpr double HEIGHT_OFFSET = 1000;  // m, added to the height of what is hidden

// What has to come into the goal region of ShellGamePush and ShellGamePick.
enum class GoalItem { kBall, kMug };
// The option of both that says so.
TaskOption add_mug_at_goal(TaskInfo& info);
inline GoalItem goal_item(const TaskOption& mug_at_goal, const Bindings& bindings) {
  return mug_at_goal.is_on(bindings) ? GoalItem::kMug : GoalItem::kBall;
}

// One row of a family's table.
struct ShellGameParams {
  TaskRow task;
  double GOAL_THRESH = 0.08;  // m
  StepRange CUE_PHASE_STEPS{1, 5};
  double MIN_DIST = 0.2;      // m, from slot to slot along y
  double BALL_RADIUS = 0.02;  // m
  double MUG_SCALE = mjcf::kMugScale;

  // Size of the mugs, as a multiple of the benchmark's.
  double mug_ratio() const { return MUG_SCALE / mjcf::kMugScale; }
  // Height of the origin of a mug that stands, m.
  double resting_height() const { return mjcf::kMugRestingHeight * mug_ratio(); }
  // Height of the mugs beyond the benchmark's, m.
  double extra_height() const { return 2 * (resting_height() - mjcf::kMugRestingHeight); }
  // Distance from the goal's centre within which `item` has to come, m.
  double placed_distance(GoalItem item) const {
    return item == GoalItem::kMug ? 1.6 * GOAL_THRESH : GOAL_THRESH;
  }

  void declare(ConstantBinder& constants);
};

// Throws Error if `params` contradict themselves with that item.
template <class Params>
void require_goal(const Params& params, GoalItem item) {
  const std::string contradiction = params.contradiction(item);
  if (!contradiction.empty()) throw Error(Error::kInvalidArgument, contradiction);
}
// Throws Error if they do with either: which one is up to the option.
template <class Params>
void require_goal(const Params& params) {
  if (params.contradiction(GoalItem::kMug).empty()) return;
  require_goal(params, GoalItem::kBall);
}

}  // namespace engram::tasks
