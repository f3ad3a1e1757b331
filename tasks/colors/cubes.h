// The cubes, nine or fewer, one of each colour: their places, and when they show.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>

#include "core/math/random.h"
#include "core/task/task.h"
#include "mjcf/scene.h"
#include "tasks/colors/params.h"
#include "tasks/common/colors.h"
#include "tasks/common/layout.h"

namespace engram::tasks {

// Room for all colours in some order.
using ColorPermutation = std::array<std::int32_t, COLOR_MAPPING.size()>;

// Colours 0, ..., count - 1 in a random order; `storage` holds them.
std::span<const std::int32_t> shuffled_colors(int count, ColorPermutation& storage,
                                              RandomStream random);

inline constexpr double kArcX = -0.25;  // m: centre of the arc on which the cubes stand

// "red", ...
std::string color_name(int color);

class ColorCubes {
 public:
  // Appends the cubes to the scene. They are its first props, so that colours are indices.
  // places: the variable of where they stand. Throws Error unless all stand apart from each other
  // and from a button, in every phase.
  ColorCubes(mjcf::Scene& scene, const ColorRecallParams& params, VariableHandle places);

  void bind(const Bindings& bindings);
  // Draws the places of the cubes in the action phase.
  void reset(const Episode& episode) const;

  // Between the cubes' places, nearer to the robot.
  Vec2 button_center(int env) const;
  // Place of a cube in the action phase.
  Vec2 slot(int env, int color) const {
    return {positions_.row(env)[2 * color], positions_.row(env)[2 * color + 1]};
  }

  // Number of the sequence's colours that a cue of `cue_steps` steps has shown when `elapsed` of
  // them are over.
  int shown(int elapsed, int cue_steps) const;
  // One step of a cue of `cue_steps` steps. The cubes that show are put back in every step, so
  // that nothing can move them.
  void show_cue(int env, std::span<const std::int32_t> sequence, int elapsed, int cue_steps) const;
  // `past`: the colours that the cue has shown so far. Bunch reports hidden cubes above the middle;
  // the others where they stood last, in x and y, or in the RL tasks where they will stand.
  void hide_all(int env, std::span<const std::int32_t> past) const;
  void show_all(int env) const;

  // Distances of the cubes from their slots, m; of the reported poses, whatever the phase.
  struct Displacement {
    double mean = 0;
    double largest = 0;
  };
  Displacement displacement(int env) const;

 private:
  int count() const { return params_.COLORS; }
  int item_steps(int cue_steps) const;
  void place(int env, int color, const Vec2& at) const;

  ColorRecallParams params_;
  VariableHandle places_;
  Layout slots_;
  Bindings engine_;
  Column<double> positions_;  // (count * 2) m
};

}  // namespace engram::tasks
