// Experts of Intercept and InterceptGrab. They catch the rolling ball: meet it, run along above it,
// come down over it and close the fingers, one before and one behind it. All scripts are the same,
// since nothing is hidden at any time.
#pragma once

#include "core/task/expert.h"
#include "tasks/intercept/ball_game.h"

namespace engram::tasks {

// Catches the ball and stops.
class GrabExpert final : public Expert {
 public:
  GrabExpert(const Bindings& engine, const BallParams& ball) : engine_(engine), ball_(ball) {}

  void act(Range envs, Script script, FloatRows actions) const override;

 private:
  const Bindings& engine_;
  BallParams ball_;
};

// Catches the ball and carries it to the target.
class DeflectExpert final : public Expert {
 public:
  // Privileged view of the task.
  struct View {
    const Bindings& engine;
    int goal_prop;
    BallParams ball;
    double goal_radius;  // m
  };

  explicit DeflectExpert(const View& view) : view_(view) {}

  void act(Range envs, Script script, FloatRows actions) const override;

 private:
  View view_;
};

}  // namespace engram::tasks
