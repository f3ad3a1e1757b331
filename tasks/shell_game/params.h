// Parameters of all shell games, named as the class constants.
#pragma once

#include <array>
#include <optional>
#include <span>
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
inline constexpr double kMinBallTravel = 0.01;  // m, where the ball's slot is in the region

// One row of a family's table.
struct ShellGameParams {
  TaskSpec task;
  double GOAL_THRESH = 0.08;  // m
  StepRange CUE_PHASE_STEPS{1, 5};
  double MIN_DIST = 0.2;      // m, from slot to slot along y
  double BALL_RADIUS = 0.02;  // m
  double MUG_SCALE = mjcf::kMugScale;
  int first_success = 0;  // control steps of the manipulation phase in which nothing succeeds

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

// Decides which one counts: in the VLA tasks a user, by the option mug_at_goal; in the RL tasks it
// is the mug.
class GoalChoice {
 public:
  GoalChoice(TaskInfo& info, const ShellGameParams& params);
  GoalItem item(std::span<const double> options) const;

 private:
  std::optional<TaskOption> mug_at_goal_;
};

// Throws Error if `params` contradict themselves with that item.
template <class Params>
void require_goal(const Params& params, GoalItem item) {
  const std::string contradiction = params.contradiction(item);
  if (!contradiction.empty()) throw Error(Error::kInvalidArgument, contradiction);
}
// Throws Error if they do with every item that may count.
template <class Params>
void require_possible_goal(const Params& params) {
  const bool either = !params.task.is_rl() && !params.contradiction(GoalItem::kMug).empty();
  require_goal(params, either ? GoalItem::kBall : GoalItem::kMug);
}

}  // namespace engram::tasks
