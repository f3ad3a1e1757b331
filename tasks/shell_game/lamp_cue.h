// The cue of the lamp games: a red, a green and a blue ball, one for each mug, and a lamp that
// later names a colour (shell 5 and 7).
#pragma once

#include <array>

#include "tasks/parts/lamp.h"
#include "tasks/shell_game/game.h"

namespace engram::tasks {

inline constexpr double LAMP_BEHIND_OFFSET_X = 0.25;  // m, from the center slot
inline constexpr double LAMP_HEIGHT = 0.06;           // m

class ShellLampCue {
 public:
  // Appends balls and lamp to the scene.
  explicit ShellLampCue(mjcf::Scene& scene);

  // Orders of the three balls.
  static constexpr int kMappingCount = 6;
  // The draw of which ball goes with which mug, and the option that keeps it constant.
  static Draw mapping_draw();
  static TaskOption fixed_mapping_option();

  void bind(const Bindings& bindings);
  // Puts balls and lamp in place. `mapping` is a draw of mapping_draw; `slots` are the positions of
  // balls in the three slots.
  void reset(int env, int mapping, const std::array<Eigen::Vector3d, kCups>& slots) const;
  // Takes the balls away: all wait above where the red one was, not under the mugs (shell 9).
  void hide_balls(int env) const;
  void show_color(int env, int color) const;

  // The mug, by its first slot, that goes with a colour: 0 red, 1 green, 2 blue.
  int mug_of(int env, int color) const { return slot_of_color_.row(env)[color]; }

 private:
  const State* state_ = nullptr;
  int first_ball_ = 0;
  Lamp lamp_;
  Column<std::uint8_t> slot_of_color_;  // (3)
};

}  // namespace engram::tasks
