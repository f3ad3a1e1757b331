// Words of BlinkCountButtonPress: how often the lamp has blinked, and which press is due.
#pragma once

#include "core/task/annotator.h"
#include "core/task/task.h"
#include "tasks/blink_count/blinks.h"
#include "tasks/common/lamp.h"
#include "tasks/common/phase_clock.h"
#include "tasks/common/press_button.h"

namespace engram::tasks {

class BlinkCountAnnotator final : public Annotator {
 public:
  // Privileged view of the task.
  struct View {
    const Bindings& engine;
    const PhaseClock& clock;
    const Blinks& blinks;
    const PressButton& red;
    const PressButton& black;
    const Lamp& lamp;                     // that blinks
    const Column<std::int32_t>& target;   // hidden: number of blinks
    const Column<std::int32_t>& presses;  // of the red button, that were lifted
  };

  explicit BlinkCountAnnotator(const View& view) : view_(view) {}

  std::vector<std::string> plan(int env) const override;
  int subtask(int env) const override;
  std::string memory(int env) const override;
  int object(int env) const override;

 private:
  int elapsed(int env) const { return view_.engine.state->elapsed[env]; }
  bool is_acting(int env) const { return elapsed(env) >= view_.clock.manipulation_start(env); }

  View view_;
};

}  // namespace engram::tasks
