// Words of GatherAndRecall: cubes to bring, and the colour of the flash.
#pragma once

#include <array>

#include "core/task/annotator.h"
#include "core/task/task.h"
#include "tasks/common/press_button.h"
#include "tasks/gather_and_recall/params.h"

namespace engram::tasks {

class GatherAnnotator final : public Annotator {
 public:
  // Privileged view of the task. The cubes are its first props.
  struct View {
    const Bindings& engine;
    const GatherParams& params;
    const std::array<PressButton, kColors>& buttons;
    const Column<std::int32_t>& flash_color;  // hidden
    const Column<std::uint8_t>& flash_triggered;
    const Column<std::uint8_t>& on_disc;  // (cubes) have been on the disc
    const Column<std::int32_t>& n_on_disc;
    const Column<std::uint8_t>& all_on_disc;  // all of them are, and rest
  };

  explicit GatherAnnotator(const View& view) : view_(view) {}

  std::vector<std::string> plan(int env) const override;
  int subtask(int env) const override;
  std::string memory(int env) const override;
  int object(int env) const override;

 private:
  int cube_to_move(int env) const;
  std::string color_name(int env) const;

  View view_;
};

}  // namespace engram::tasks
