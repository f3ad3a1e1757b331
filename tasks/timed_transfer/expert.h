// Expert of TimedTransfer: waits over the red disc with the cube in the gripper, and lowers it when
// it is due.
#pragma once

#include "core/task/expert.h"
#include "tasks/common/sampled_range.h"
#include "tasks/timed_transfer/reward.h"

namespace engram::tasks {

class TimedTransferExpert final : public Expert {
 public:
  // Privileged view of the task.
  struct View {
    const Bindings& engine;
    const Column<std::int32_t>& signal_step;  // hidden
    int cube;                                 // indices of props
    int red_disc;
    double resting_height;  // m, of the cube on a disc
    int delay_steps;
    double tolerance;  // of the delay
    const WindowRounding& rounding;
    StepRange signal_steps;
  };

  explicit TimedTransferExpert(const View& view) : view_(view) {}

  void act(Range envs, Script script, FloatRows actions) const override;

 private:
  TimeWindow window(int signal_step) const {
    return time_window(signal_step, view_.delay_steps, view_.tolerance, view_.rounding);
  }
  int due_step(int env, Script script, bool narrow) const;
  int guessed_count(int env) const;

  View view_;
};

}  // namespace engram::tasks
