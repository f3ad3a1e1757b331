#include "core/sim/state.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/collision/contact_pair.h"
#include "core/math/real_functions.h"

namespace engram {

State::State(ColumnStore& store, int props, int contact_pairs)
    : num_props(props), num_contact_pairs(contact_pairs) {
  seed = store.add<std::uint64_t>("seed");
  episode = store.add<std::uint64_t>("episode");
  elapsed = store.add<std::int32_t>("elapsed", 1, "control steps");
  finished = store.add<std::uint8_t>("finished");

  qpos = store.add<double>("qpos", kRobotJoints, "rad, m");
  qvel = store.add<double>("qvel", kRobotJoints, "rad/s, m/s");
  tcp_pos = store.add<double>("tcp_pos", 3, "m");
  tcp_quat = store.add<double>("tcp_quat", 4);
  target_qpos = store.add<double>("target_qpos", kRobotJoints, "rad, m");
  target_pose = store.add<double>("target_pose_in_root", 7);

  // A scene without props keeps one unused element, so that every column exists.
  const int width = std::max(1, props);
  prop_pos = store.add<double>("prop_pos", 3 * width, "m");
  prop_quat = store.add<double>("prop_quat", 4 * width);
  prop_qvel = store.add<double>("prop_qvel", 6 * width, "m/s, rad/s");
  prop_status = store.add<std::uint8_t>("prop_status", width);
  prop_slow_steps = store.add<std::uint8_t>("prop_slow_steps", width);
  prop_rgba = store.add<float>("prop_rgba", 4 * width);
  prop_emission = store.add<float>("prop_emission", width);
  covered = store.add<std::uint64_t>("covered");
  finger_force = store.add<double>("finger_force", 6 * width, "N");
  const int pairs = std::max(1, contact_pairs);
  contact_ids = store.add<std::int32_t>("contact_ids", StoredPair::kInts * pairs);
  contact_values = store.add<float>("contact_values", StoredPair::kFloats * pairs);

  store.limit("finished", 0, 1);
  store.limit("prop_status", 0, static_cast<int>(PropStatus::kAwake));
}

void State::place_prop(int env, int prop, const double* pos, const double* quat,
                       PropStatus status) const {
  std::copy_n(pos, 3, prop_pos_of(env, prop));
  std::copy_n(quat, 4, prop_quat_of(env, prop));
  std::fill_n(prop_qvel_of(env, prop), 6, 0.0);
  std::fill_n(finger_force.row(env) + 6 * prop, 6, 0.0);
  prop_status.row(env)[prop] = static_cast<std::uint8_t>(status);
  prop_slow_steps.row(env)[prop] = 0;
  forget_contacts(env, prop);
}

void State::forget_contacts(int env, int prop) const {
  for (int i = 0; i < num_contact_pairs; ++i) {
    std::int32_t* const ids = contact_ids.row(env) + i * StoredPair::kInts;
    if (StoredPair::is_empty(ids)) return;
    if (StoredPair::holds_prop(ids, prop)) StoredPair::forget(ids);
  }
}

void State::move_kinematic(int env, int prop, const double* pos) const {
  const double* from = prop_pos_of(env, prop);
  double* displacement = prop_qvel_of(env, prop);
  for (int i = 0; i < 3; ++i) displacement[i] = pos[i] - from[i];
  prop_status.row(env)[prop] = static_cast<std::uint8_t>(PropStatus::kAwake);
}

void State::hide_prop(int env, int prop, const double* pos) const {
  static constexpr double kUpright[4] = {1, 0, 0, 0};
  place_prop(env, prop, pos, kUpright, PropStatus::kHidden);
}

bool robot_is_static(const State& state, int env, double threshold) {
  const double* qvel = state.qvel.row(env);
  return std::all_of(qvel, qvel + kArmJoints,
                     [threshold](double v) { return std::abs(v) <= threshold; });
}

bool prop_is_static(const State& state, int env, int prop, double linear_threshold,
                    double angular_threshold) {
  const Eigen::Map<const Eigen::Matrix<double, 6, 1>> qvel(state.prop_qvel_of(env, prop));
  return qvel.head<3>().norm() <= linear_threshold && qvel.tail<3>().norm() <= angular_threshold;
}

bool is_grasping(const State& state, int env, int prop, double min_force, double max_angle) {
  const double* quat = state.tcp_quat.row(env);
  // The fingers' frames are parallel to the hand's; the left one opens along +y.
  const Eigen::Vector3d opening =
      Eigen::Quaterniond(quat[0], quat[1], quat[2], quat[3]) * Eigen::Vector3d::UnitY();
  const double min_cosine = real::cos(max_angle * std::numbers::pi / 180.0);
  for (int finger = 0; finger < kFingers; ++finger) {
    const Eigen::Map<const Eigen::Vector3d> force(state.finger_force.row(env) + 6 * prop +
                                                  3 * finger);
    const double norm = force.norm();
    if (norm < min_force || norm < 1e-6) return false;
    const double along = (finger == 0 ? 1.0 : -1.0) * opening.dot(force);
    if (along < min_cosine * norm) return false;
  }
  return true;
}

}  // namespace engram
