// Cubes that count, the flash and the dense reward of GatherAndRecall.
#pragma once

#include <Eigen/Dense>
#include <vector>

#include "tasks/common/action_cost.h"
#include "tasks/common/layout.h"

namespace engram::tasks {

inline constexpr double CUBE_VEL_THRESH = 0.15;  // m/s
inline constexpr double CUBE_CLUSTER_SPACING_SCALE = 4.5;
inline constexpr double CUBE_CLUSTER_X_OFFSET = -0.08;  // m from the disc
inline constexpr double CUBE_CLUSTER_CENTER_Y = -0.26;  // m
inline constexpr double kGatherSuccessReward = 50;
inline constexpr double FAILURE_PENALTY = 25;
inline constexpr SmoothnessParams kGatherSmoothness = {
    .ACTION_L2_COEF = 0.01, .ACTION_DELTA_L2_COEF = 0.03, .QVEL_L2_COEF = 0.01};

// Place of a cube in the cluster, jitter aside.
Vec2 cluster_place(int cube, int cubes, double half_size, const Vec2& disc);

// True if a cube counts as on the disc. One that is carried slowly above it does too.
bool is_on_disc(const Eigen::Vector3d& pos, const Eigen::Vector3d& velocity, const Vec2& disc,
                double threshold = 0.10);

// The one flash of an episode.
struct Flash {
  bool triggered = false;
  int start = 0;  // value of elapsed
};

// Begins the flash once enough cubes have been on the disc. True while it lasts.
bool update_flash(Flash& flash, int cubes_on_disc, int trigger_count, int duration, int elapsed);

// Dense reward (tasks/common/reward_dict.h).
struct GatherReward {
  double goal_distance = 0;  // norm of obj_to_goal_pos, m
  int cubes = 1;             // of the variant
  int cubes_on_disc = 0;     // that have been there
  bool all_on_disc = false;
  double correct_depth = 0;  // of the correct button, as a fraction of its travel
  ActionCost action_cost = {};
  bool failed = false;
  bool success = false;
  SmoothnessParams smoothness = kGatherSmoothness;
  // Terms.
  double reaching = 0;
  double progress = 0;
  double press = 0;
  SmoothnessTerms smooth = {};

  double compute();
  template <class Visitor>
  void list_terms(Visitor& row) const {
    row.term("reaching_reward", "", reaching);
    row.term("place_progress", "", progress);
    row.term("n_on_disc", "", cubes_on_disc);
    row.term("button_press_reward", "", press);
    row.term("smooth_penalty", "", smooth.penalty);
    smooth.list_parts(row);
  }
};

}  // namespace engram::tasks
