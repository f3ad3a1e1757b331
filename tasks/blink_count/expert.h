// Expert of BlinkCountButtonPress: presses red until the count is right, then black.
#pragma once

#include "core/task/answer_controller.h"
#include "core/task/expert.h"
#include "tasks/blink_count/params.h"
#include "tasks/common/phase_clock.h"
#include "tasks/common/press_button.h"

namespace engram::tasks {

class BlinkCountExpert final : public Expert, public AnswerController {
 public:
  // Privileged view of the task.
  struct View {
    const Bindings& engine;
    const TaskInfo& info;
    const BlinkCountParams& params;
    const PhaseClock& clock;
    const PressButton& red;
    const PressButton& black;
    const Column<std::int32_t>& target;  // hidden: blinks
    const Column<std::int32_t>& press_count;
    const Column<std::uint8_t>& submit_attempted;
  };

  explicit BlinkCountExpert(const View& view) : view_(view) {}

  void act(Range envs, Script script, FloatRows actions) const override;
  ChoiceForm choice_form() const override;
  bool is_choice_due(int env) const override { return is_acting(env) && awaits_choice(env); }

 private:
  bool is_acting(int env) const {
    return view_.engine.state->elapsed[env] >= view_.clock.manipulation_start(env);
  }
  void press(int env, int count, float* action) const;
  void sweep(int env, float* action) const;
  int guess(int env) const;

  View view_;
};

}  // namespace engram::tasks
