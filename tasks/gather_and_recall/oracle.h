// Gathers the cubes, then presses a button. Nothing is remembered between steps.
#pragma once

#include <array>

#include "tasks/common/grasp_servo.h"
#include "tasks/common/layout.h"
#include "tasks/common/press_button.h"
#include "tasks/gather_and_recall/params.h"

namespace engram::tasks {

struct GatherGoal {
  Vec2 disc;             // centre, m
  int color = 0;         // of the button to press
  bool pressed = false;  // a button has been
};

class GatherOracle {
 public:
  GatherOracle(const GatherParams& params, const std::array<PressButton, kColors>& buttons)
      : cubes_(params.N_CUBES), threshold_(params.DISC_ON_THRESH), buttons_(buttons) {}

  void act(const State& state, int env, const GatherGoal& goal, float* action) const;
  // Without memory: presses the button of the colour that the lamp shows now, -1 being none; after
  // that the nearest one.
  void sweep(const State& state, int env, const Vec2& disc, int shown, float* action) const;

 private:
  // True once all cubes lie on the disc and the tool is clear of them.
  bool bring_cubes(const State& state, int env, const Vec2& disc, float* action) const;
  void press(const State& state, int env, const GatherGoal& goal, float* action) const;
  // The same from amid the cubes: the fingers open first.
  void drop_and_press(const State& state, int env, int color, float* action) const;
  bool all_over(const State& state, int env, const Vec2& disc) const;
  int nearest_button(int env) const;

  int cubes_;
  double threshold_;  // m: DISC_ON_THRESH
  const std::array<PressButton, kColors>& buttons_;
};

}  // namespace engram::tasks
