#include "tasks/shell_game/pick_params.h"

#include <algorithm>

#include "tasks/common/phase_budget.h"
#include "tasks/shell_game/mugs.h"

namespace engram::tasks {
namespace {

// Least requirements of a lift.
constexpr double kFingerRoom = 0.028;  // m, between two mugs
constexpr double kMinLift = 0.001;     // m
constexpr double kLiftPerStep = 0.01;  // m
constexpr double kUsualLift = 0.02;    // m, in kTimeToPick
constexpr int kTimeToPick = 19;        // control steps, the hand hovers over the mug
constexpr int kTimeToTurn = 20;        // control steps until it does, where it waits for the mugs

}  // namespace

double PickParams::answer_distance(GoalItem item) const {
  // From there on a mug may show what is under it.
  if (task.is_rl() || item == GoalItem::kBall) return kLiftThatShows;
  return lift() / 2;
}

std::string PickParams::contradiction(GoalItem item) const {
  if (item == GoalItem::kBall || lift() >= kMinLift) return {};
  return "cups are in the goal region from the start: 1.6 x GOAL_THRESH = " +
         in_millimetres(placed_distance(item)) + ", and its centre is " + in_millimetres(height()) +
         " above a cup that nobody has moved";
}

void PickParams::declare(ConstantBinder& constants) {
  ShellGameParams::declare(constants);
  if (task.is_rl()) return;
  constants.fixed({{"HANDLE_OFFSET_X", HANDLE_OFFSET_X}, {"HANDLE_OFFSET_Y", HANDLE_OFFSET_Y}});
}

void PickParams::check(int horizon) const {
  if (task.is_rl()) {
    for (const MugOrientation& orientation : kHandleTurns)
      check_mugs(*this, orientation, kFingerRoom);
  } else {
    check_mugs(*this, kHandleTowardsRobot, kFingerRoom);
  }
  require_possible_goal(*this);
  const int more = static_cast<int>(std::max(0.0, lift() - kUsualLift) / kLiftPerStep);
  check_horizon(horizon, {{"CUE_PHASE_STEPS", CUE_PHASE_STEPS.high}},
                kTimeToPick + (task.is_rl() ? kTimeToTurn : 0) + more);
}

}  // namespace engram::tasks
