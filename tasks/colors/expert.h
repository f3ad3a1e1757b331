// Expert of SeqOfColors, ChainOfColors and BunchOfColors: touches cubes from above with open
// fingers, then presses the button, if there is one, with closed ones.
#pragma once

#include <span>

#include "core/task/answer_controller.h"
#include "core/task/expert.h"
#include "tasks/colors/cubes.h"
#include "tasks/colors/params.h"
#include "tasks/common/phase_clock.h"
#include "tasks/common/press_button.h"
#include "tasks/common/touch_latch.h"

namespace engram::tasks {

class ColorRecallExpert final : public Expert, public AnswerController {
 public:
  // Privileged view of the task.
  struct View {
    const Bindings& engine;
    const TaskInfo& info;
    const ColorRecallParams& params;
    const ColorRule& rule;  // by which touches are judged
    const ColorCubes& cubes;
    const PhaseClock& clock;
    const TouchLatch& touch;
    const Column<std::int32_t>& sequence;  // hidden: colours of the cue
    // Null where touches are all.
    const PressButton* button = nullptr;
    const Column<std::uint8_t>* button_pressed = nullptr;
  };

  explicit ColorRecallExpert(const View& view) : view_(view) {}

  void act(Range envs, Script script, FloatRows actions) const override;
  ChoiceForm choice_form() const override;
  bool is_choice_due(int env) const override { return is_acting(env) && awaits_choice(env); }

  const View& view() const { return view_; }
  // The cube that the oracle touches next, -1 once all have been touched.
  int next_target(int env) const;

 private:
  bool is_acting(int env) const {
    return view_.clock.phase(env, view_.engine.state->elapsed[env]) == Phase::kManipulation;
  }
  bool is_done(int env, int next) const;
  double travel_height(int env, int color) const;
  Eigen::Vector3d touch_waypoint(int env, int color) const;
  bool leaves_early() const;
  void wait(int env, float* action) const;
  void approach(int env, const Eigen::Vector3d& goal, float* action) const;
  void touch(int env, int color, float* action) const;
  void touch_in_passing(int env, int color, float* action) const;
  void press(int env, float* action) const;
  void sweep(int env, float* action) const;
  void sweep_button(int env, int since, float* action) const;
  int next_color(int env, std::span<const std::int32_t> targets) const;
  int color_in_row(int env, int place) const;
  std::span<const std::int32_t> guess(int env, ColorPermutation& storage) const;

  View view_;
};

}  // namespace engram::tasks
