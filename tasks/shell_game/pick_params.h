// Parameters of ShellGamePick.
#pragma once

#include <Eigen/Core>
#include <array>

#include "tasks/shell_game/params.h"

namespace engram::tasks {

struct PickParams : ShellGameParams {
  double goal_height = 0.125;  // m, of the goal's centre above the ball's

  Eigen::Vector3d goal_from_ball() const { return {0, 0, goal_height}; }
  // Height of the goal's centre above a mug in its slot, m.
  double height() const { return BALL_RADIUS + goal_height - resting_height(); }
  // Height to which a mug has to be lifted, m.
  double lift() const { return height() - placed_distance(GoalItem::kMug); }
  // A mug that is moved farther is the robot's answer, m.
  double answer_distance(GoalItem item) const;

  // Why everybody would succeed; empty if that is not so.
  std::string contradiction(GoalItem item) const;
  void declare(ConstantBinder& constants);
  void check(int horizon) const;
};

inline constexpr std::array<PickParams, 2> kPickVariants = {{
    {{.task = {"ShellGamePick-VLA-v0", 30, Split::kExtended}, .GOAL_THRESH = 0.05}},
    {{.task =
          {.id = "ShellGamePick-v0", .horizon = 90, .split = Split::kRl, .memory_type = "Object"},
      .GOAL_THRESH = 0.05,
      .CUE_PHASE_STEPS = {5, 5},
      .MUG_SCALE = 1,
      .first_success = 1},
     0.1242722},
}};

// Where the VLA task expects the handle, from the mug's origin, in world axes.
inline constexpr double HANDLE_OFFSET_X = 0.045;  // m, towards the robot
inline constexpr double HANDLE_OFFSET_Y = 0.043;  // m

// How near the TCP has to come to what the reward leads it to.
inline constexpr double kPickReach = 0.04;  // m
inline constexpr double kPickSuccessReward = 75;

}  // namespace engram::tasks
