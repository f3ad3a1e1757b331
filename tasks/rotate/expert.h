// Experts of RotateLenient and RotateStrict: push one end of the peg sideways with the closed
// fingers, or grasp it at its centre and turn the hand.
#pragma once

#include "core/task/expert.h"
#include "tasks/rotate/peg_angle.h"

namespace engram::tasks {

// Size of the peg, which lies on the table.
struct PegSize {
  double half_width = 0.025;  // m
  double half_length = 0.12;
};

class RotateExpert final : public Expert {
 public:
  // Privileged view of the task.
  struct View {
    const Bindings& engine;
    const TaskInfo& info;
    const Column<double>& target;            // hidden: rad
    const Column<double>& initial_yaw;       // rad
    const Column<double>& initial_position;  // (2) m
    RotateMode mode;
    bool strict;
    double threshold;  // rad: error within which the peg has turned far enough
    PegSize peg;
  };

  explicit RotateExpert(const View& view) : view_(view) {}

  void act(Range envs, Script script, FloatRows actions) const override;

 private:
  // Goal of one step.
  struct Goal {
    double turn = 0;    // still to be turned, rad
    bool wait = false;  // with the peg in the hand
    double x = 0;       // m: place of the centre
    double y = 0;
  };

  Goal measured_goal(int env, Script script) const;
  Goal timed_goal(int env) const;
  double guess(int env) const;
  void push_peg(int env, const Goal& goal, float* action) const;
  void turn_peg(int env, const Goal& goal, float* action) const;

  View view_;
};

}  // namespace engram::tasks
