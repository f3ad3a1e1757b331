#include "tasks/shell_game/params.h"

#include "tasks/common/phase_budget.h"

namespace engram::tasks {

GoalChoice::GoalChoice(TaskInfo& info, const ShellGameParams& params) {
  if (params.task.is_rl()) return;
  mug_at_goal_ =
      TaskOptions(info.options)
          .on_off("mug_at_goal",
                  "1: the mug has to come within 1.6 GOAL_THRESH of the goal, not the ball within "
                  "GOAL_THRESH",
                  /*original=*/true);
}

GoalItem GoalChoice::item(std::span<const double> options) const {
  const bool mug = !mug_at_goal_ || mug_at_goal_->is_on(options);
  return mug ? GoalItem::kMug : GoalItem::kBall;
}

void ShellGameParams::declare(ConstantBinder& constants) {
  constants
      .steps("CUE_PHASE_STEPS", CUE_PHASE_STEPS, kPhaseSteps, "how long the cue is shown",
             {"cue_steps", "length of the cue phase"})
      .published = !task.is_rl();
  // The original's RL tasks have one length, by another name.
  if (task.is_rl()) constants.fixed({{"TIME_OFFSET", CUE_PHASE_STEPS.high}});
  constants.real("MIN_DIST", MIN_DIST, {0.1, 0.35}, "m", "from one cup's slot to the next one's");
  constants.real("BALL_RADIUS", BALL_RADIUS, {0.01, 0.06}, "m", "of the balls under the cups");
  constants.real("GOAL_THRESH", GOAL_THRESH, {0.01, 0.3}, "m",
                 "how near its cup's origin the tool has to come; where a cup is moved: radius of "
                 "the goal region");
  constants.fixed({{"HEIGHT_OFFSET", HEIGHT_OFFSET}});
  constants.real("MUG_SCALE", MUG_SCALE, {0.7, 2}, "",
                 "size of the cups, as a multiple of the scan's");
}

}  // namespace engram::tasks
