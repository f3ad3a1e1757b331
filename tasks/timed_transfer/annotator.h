// Words of TimedTransfer: when the lamp turned green, and what the cube waits for.
#pragma once

#include "core/task/annotator.h"
#include "core/task/task.h"
#include "tasks/common/lamp.h"
#include "tasks/timed_transfer/reward.h"

namespace engram::tasks {

class TimedTransferAnnotator final : public Annotator {
 public:
  // Privileged view of the task.
  struct View {
    const Bindings& engine;
    const Column<std::int32_t>& signal_step;  // hidden
    const Lamp& lamp;
    int cube;      // prop
    int red_disc;  // prop
    int delay_steps;
    double tolerance;
    const WindowRounding& rounding;
  };

  explicit TimedTransferAnnotator(const View& view) : view_(view) {}

  std::vector<std::string> plan(int env) const override;
  int subtask(int env) const override;
  std::string memory(int env) const override;
  int object(int env) const override;

 private:
  CountPhase count(int env) const;

  View view_;
};

}  // namespace engram::tasks
