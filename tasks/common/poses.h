// Positions and poses of TCP and props; placing a prop upright on the table.
#pragma once

#include <Eigen/Dense>

#include "core/sim/state.h"

namespace engram::tasks {

inline constexpr double kUprightQuat[4] = {1, 0, 0, 0};  // quaternion (w, x, y, z)

// Positions in the world, m.
inline Eigen::Vector3d tcp_pos(const State& state, int env) {
  return Eigen::Map<const Eigen::Vector3d>(state.tcp_pos.row(env));
}
inline Eigen::Vector3d prop_pos(const State& state, int env, int prop) {
  return Eigen::Map<const Eigen::Vector3d>(state.prop_pos_of(env, prop));
}

// A pose as observations report it: three numbers in m and a quaternion (w, x, y, z).
struct Pose {
  const double* pos;
  const double* quat;
};
inline Pose prop_pose(const State& state, int env, int prop) {
  return {state.prop_pos_of(env, prop), state.prop_quat_of(env, prop)};
}

// Places a prop upright; `height`: of its origin, m.
inline void place_upright(const State& state, int env, int prop, const Eigen::Vector2d& at,
                          double height) {
  const double pos[3] = {at.x(), at.y(), height};
  state.place_prop(env, prop, pos, kUprightQuat);
}

}  // namespace engram::tasks
