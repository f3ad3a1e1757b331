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

GatherRewardTerms gather_reward(const GatherRewardInputs& inputs) {
  GatherRewardTerms terms;
  terms.reaching = 1 - real::tanh(8 * inputs.goal_distance);
  terms.progress = static_cast<double>(inputs.cubes_on_disc) / inputs.cubes;
  terms.press = inputs.all_on_disc ? std::clamp(inputs.correct_depth, 0.0, 1.0) : 0.0;
  terms.smooth = smoothness(inputs.action_cost, inputs.smoothness);
  terms.reward = 2 * terms.reaching + 10 * terms.progress + 5 * terms.press - terms.smooth.penalty;
  if (inputs.all_on_disc) terms.reward += 3 * terms.reaching;
  if (inputs.failed) terms.reward = -FAILURE_PENALTY;
  if (inputs.success) terms.reward = kGatherSuccessReward;
  return terms;
}

}  // namespace engram::tasks
