// Columns of a few environments with the props of the mixed scene, for tests of the simulator's
// parts.
#pragma once

#include <algorithm>

#include "core/contact/contact_step.h"
#include "core/sim/state.h"
#include "tests/core/scene/props.h"

namespace engram::test {

// The robot at its start pose; the first cube falls, the ball sleeps, the second cube is hidden,
// the kinematic box stands.
struct MixedColumns {
  explicit MixedColumns(int num_envs = 1)
      : store(num_envs), state(store, 4, max_stored_pairs(mixed_model().collision())) {
    for (int env = 0; env < num_envs; ++env) {
      std::copy(kStartPose.begin(), kStartPose.end(), state.qpos.row(env));
      place(env, kCube0, {0.0, 0.4, 0.1}, PropStatus::kAwake);
      place(env, kBall, {0.1, -0.4, 0.03}, PropStatus::kAsleep);
      place(env, kCube1, {0.3, 0.6, 0.02}, PropStatus::kHidden);
      place(env, kBox, {-0.2, 0.5, 0.02}, PropStatus::kAsleep);
    }
  }
  void place(int env, int prop, const Eigen::Vector3d& pos, PropStatus status) const {
    const double upright[4] = {1, 0, 0, 0};
    state.place_prop(env, prop, pos.data(), upright, status);
  }

  ColumnStore store;
  State state;
};

}  // namespace engram::test
