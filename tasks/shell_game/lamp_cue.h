// Cue of the lamp games: a red, a green and a blue ball, one for each mug, and a lamp that later
// names a colour.
#pragma once

#include "tasks/common/lamp.h"
#include "tasks/common/task_options.h"
#include "tasks/shell_game/game.h"

namespace engram::tasks {

class LampCue {
 public:
  // Random variable of the lamp's colour.
  static constexpr const char* kTarget = "target_color";
  static constexpr const char* kTargetDescription = "colour of the lamp: 0 red, 1 green, 2 blue";
  // Class constants of the lamp.
  static void declare(ConstantBinder& constants);

  // Appends balls and lamp to the scene, and the variable of the mapping from balls to mugs.
  LampCue(mjcf::Scene& scene, double ball_radius, RandomVariables list);

  // Adds the option that keeps the mapping constant.
  void describe(TaskInfo& info);
  void bind(const Bindings& bindings);
  // True if the mapping is the same in every episode, unless it is pinned.
  bool is_fixed() const;

  // Draws the mapping; puts balls and lamp in place.
  void reset(const Episode& episode, const Mugs& mugs) const;
  // Takes the balls away: all wait above where the red one was, not under the mugs.
  void hide_balls(int env) const;
  void show_color(int env, int color) const;

  // The mug, by its first slot, that goes with a colour: 0 red, 1 green, 2 blue.
  int mug_of(int env, int color) const { return slot_of_color_.row(env)[color]; }
  // Shows the colour in info.
  void publish_color(int env, int color) const { task_cue_[env] = static_cast<float>(color); }

  // The state observation of the lamp games.
  template <class Visitor>
  static void state_row(Visitor& row, const ShellGame& game, int env) {
    row.field("obj_to_goal_pos", 3, "m", "position of the target slot minus TCP",
              [&] { return game.obj_to_goal(env); });
    row.field("target_color", 1, "", "0 red, 1 green, 2 blue", [&] { return game.target(env); });
    row.field("oracle_info", 1, "", "slot of that colour's mug in the end",
              [&] { return game.answer(env); });
  }

 private:
  int first_ball_;
  double ball_radius_;  // m
  Lamp lamp_;
  IntegerVariable mapping_;
  TaskOption fixed_mapping_;
  Bindings engine_;
  Column<std::uint8_t> slot_of_color_;  // (3)
  Column<float> task_cue_;              // in info only: policies get the colour from the lamp
};

}  // namespace engram::tasks
