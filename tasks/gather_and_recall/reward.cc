#include "tasks/gather_and_recall/reward.h"

#include <algorithm>

#include "core/math/real_functions.h"

namespace engram::tasks {

Vec2 cluster_place(int cube, int cubes, double half_size, const Vec2& disc) {
  constexpr int kColumns = 3;
  const double spacing = half_size * CUBE_CLUSTER_SPACING_SCALE;
  const int rows = (cubes + kColumns - 1) / kColumns;
  const int row = cube / kColumns;
  const int in_row = std::min(kColumns, cubes - kColumns * row);
  return {disc.x() + CUBE_CLUSTER_X_OFFSET + (cube % kColumns - (in_row - 1) / 2.0) * spacing,
          CUBE_CLUSTER_CENTER_Y + (row - (rows - 1) / 2.0) * spacing};
}

bool is_on_disc(const Eigen::Vector3d& pos, const Eigen::Vector3d& velocity, const Vec2& disc,
                double threshold) {
  constexpr double kCeiling = 0.5;  // m
  return (pos.head<2>() - disc).norm() < threshold && pos.z() < kCeiling &&
         velocity.norm() < CUBE_VEL_THRESH;
}

bool update_flash(Flash& flash, int cubes_on_disc, int trigger_count, int duration, int elapsed) {
  if (!flash.triggered && cubes_on_disc >= trigger_count) flash = {true, elapsed};
  return flash.triggered && elapsed - flash.start < duration;
}

double GatherReward::compute() {
  reaching = 1 - real::tanh(8 * goal_distance);
  progress = static_cast<double>(cubes_on_disc) / cubes;
  press = all_on_disc ? std::clamp(correct_depth, 0.0, 1.0) : 0.0;
  smooth = tasks::smoothness(action_cost, smoothness);
  if (success) return kGatherSuccessReward;
  if (failed) return -FAILURE_PENALTY;
  const double reward = 2 * reaching + 10 * progress + 5 * press - smooth.penalty;
  return all_on_disc ? reward + 3 * reaching : reward;
}

}  // namespace engram::tasks
