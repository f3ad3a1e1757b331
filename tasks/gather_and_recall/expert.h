// Expert of GatherAndRecall: gathers the cubes, then presses a button. Nothing is remembered
// between steps.
#pragma once

#include <array>

#include "core/base/index.h"
#include "core/task/answer_controller.h"
#include "core/task/expert.h"
#include "tasks/common/layout.h"
#include "tasks/common/press_button.h"
#include "tasks/gather_and_recall/params.h"

namespace engram::tasks {

class GatherExpert final : public Expert, public AnswerController {
 public:
  // Privileged view of the task. The cubes are its first props.
  struct View {
    const Bindings& engine;
    const GatherParams& params;
    const std::array<PressButton, kColors>& buttons;
    const Column<double>& disc;               // (2) m, of the centre
    const Column<std::int32_t>& flash_color;  // hidden
    const Column<std::uint8_t>& flash_active;
    const Column<std::uint8_t>& flash_triggered;
    const Column<std::int32_t>& pressed_button;  // -1: none
  };

  explicit GatherExpert(const View& view) : view_(view) {}

  void act(Range envs, Script script, FloatRows actions) const override;
  ChoiceForm choice_form() const override;
  bool is_choice_due(int env) const override;

 private:
  void gather_and_press(int env, int color, float* action) const;
  void sweep(int env, float* action) const;
  // True once all cubes lie around `center` and the tool is clear of them.
  bool bring_cubes(int env, const Vec2& center, float* action) const;
  void press(int env, int color, float* action) const;
  // Presses from amid the cubes: the fingers open first.
  void drop_and_press(int env, int color, float* action) const;
  bool all_over_disc(int env) const;
  int nearest_button(int env) const;
  int guess(int env) const;
  Vec2 disc(int env) const { return Eigen::Map<const Vec2>(view_.disc.row(env)); }
  const PressButton& button(int color) const { return view_.buttons[at(color)]; }

  View view_;
};

}  // namespace engram::tasks
