// What wakes sleeping props, and what lets them sleep.
#include "core/physics/proximity.h"
#include "core/physics/step.h"

namespace engram {
namespace {

// Props may stand a millimetre apart without waking one another.
constexpr double kPropWakeGap = 0.0005;  // m

// A free prop that is slower than this for so many control steps, with nothing that moves near
// it, goes to sleep.
constexpr double kSleepLinearSpeed = 0.005;  // m/s
constexpr double kSleepAngularSpeed = 0.05;  // rad/s
constexpr int kSleepSteps = 5;

bool spheres_near(const Eigen::Vector3d& a, double radius_a, const Eigen::Vector3d& b,
                  double radius_b) {
  const double reach = radius_a + radius_b + kPropWakeGap;
  return (a - b).squaredNorm() <= reach * reach;
}

}  // namespace

// --- where things are ---

void Physics::Step::locate(int prop, const double* pos, const double* quat) {
  Frame& frame = bench_.frames[at(prop)];
  frame = make_frame(pos, quat);
  bench_.frame_known[at(prop)] = 1;
  bench_.centers[at(prop)] = frame.pos + frame.axes * prop_model(prop).bounding_center;
}

void Physics::Step::locate_remembered(int prop) {
  const double* pos = state_.prop_pos_of(env_, prop);
  if (!prop_model(prop).bounding_center.isZero(0)) {
    locate(prop, pos, state_.prop_quat_of(env_, prop));
    return;
  }
  bench_.frame_known[at(prop)] = 0;
  bench_.centers[at(prop)] = Eigen::Map<const Eigen::Vector3d>(pos);
}

const Frame& Physics::Step::frame_of(int prop) const {
  Frame& frame = bench_.frames[at(prop)];
  if (bench_.frame_known[at(prop)] == 0) {
    frame = make_frame(state_.prop_pos_of(env_, prop), state_.prop_quat_of(env_, prop));
    bench_.frame_known[at(prop)] = 1;
  }
  return frame;
}

void Physics::Step::locate_awake() {
  if (scene_index_ <= PhysicsModel::kRobotScene) return;
  for (int prop = 0; prop < num_props(); ++prop) {
    if (!is_awake(prop)) continue;
    const mjtNum* qpos = data_->qpos + slot_of(prop).qpos;
    locate(prop, qpos, qpos + 3);
  }
}

double Physics::Step::lowest_reach() const {
  double lowest = kFarAway;
  for (const int geom : model_.reach_geoms()) {
    lowest = std::min(lowest, data_->geom_xpos[3 * geom + 2] - scene_->model->geom_rbound[geom]);
  }
  return lowest;
}

double Physics::Step::robot_beyond(int prop, double lowest) const {
  const Eigen::Vector3d& center = bench_.centers[at(prop)];
  const double radius = reach_of(prop) + kWakeGap;
  const double below = lowest - center.z() - radius;
  if (below > 0) return below;
  double least = kFarAway;
  for (std::size_t i = 0; i < model_.reach_geoms().size() && least > 0; ++i) {
    const int geom = model_.reach_geoms()[i];
    double beyond = sphere_to_geom(*scene_->model, *data_, geom, center, radius);
    if (beyond <= 0 && !is_gliding(prop)) {
      beyond = parts_beyond(kWakeGap, std::span(&model_.reach_boxes()[i], 1),
                            geom_frame(*data_, geom), prop_model(prop).parts, frame_of(prop));
    }
    least = std::min(least, beyond);
  }
  return least;
}

bool Physics::Step::props_near(int prop, int other) const {
  return spheres_near(bench_.centers[at(prop)], prop_model(prop).bounding_radius,
                      bench_.centers[at(other)], prop_model(other).bounding_radius) &&
         parts_beyond(kPropWakeGap, prop_model(prop).parts, frame_of(prop), prop_model(other).parts,
                      frame_of(other)) <= 0;
}

bool Physics::Step::awake_prop_near(int prop) const {
  for (int other = 0; other < num_props(); ++other) {
    if (is_awake(other) && props_near(prop, other)) return true;
  }
  return false;
}

// --- waking and sleeping ---

// A prop that was farther away than the robot has moved since need not be looked at again.
bool Physics::Step::robot_reaches(int prop, std::optional<double>& lowest) {
  double& beyond = bench_.beyond[at(prop)];
  if (beyond > 0) return false;
  if (!lowest) lowest = lowest_reach();
  beyond = robot_beyond(prop, *lowest);
  return beyond <= 0;
}

bool Physics::Step::wake_what_is_near() {
  locate_awake();
  const double way = model_.robot_bounds().way_from(seen_qpos_, *data_);
  std::copy_n(data_->qpos, kRobotJoints, seen_qpos_.begin());
  std::optional<double> lowest;
  bool kinematic = scene_->has_kinematic_props;
  bool changed = false;
  for (int prop = 0; prop < num_props(); ++prop) {
    if (!is_status(prop, PropStatus::kAsleep) || !prop_model(prop).tangible()) continue;
    const bool free = prop_model(prop).free;
    if (!free && kinematic) continue;
    bench_.beyond[at(prop)] -= way;
    if (!robot_reaches(prop, lowest) && !(free && awake_prop_near(prop))) continue;
    if (!changed) harvest();
    changed = true;
    if (free) prepare_awake(prop);
    kinematic = true;  // awake props meet kinematic ones too
  }
  if (changed) {
    enter(model_.smallest_scene(bench_.awake_by_type, kinematic), data_->qpos, data_->qvel,
          data_->qacc_warmstart);
  }
  return changed;
}

void Physics::Step::put_to_sleep() {
  const double lowest = lowest_reach();
  std::uint8_t* slow = state_.prop_slow_steps.row(env_);
  for (int prop = 0; prop < num_props(); ++prop) {
    if (!is_awake(prop)) continue;
    const bool resting =
        prop_is_static(state_, env_, prop, kSleepLinearSpeed, kSleepAngularSpeed) &&
        robot_beyond(prop, lowest) > 0 && !gliding_near(prop);
    slow[prop] = resting ? static_cast<std::uint8_t>(std::min(slow[prop] + 1, kSleepSteps))
                         : std::uint8_t{0};
  }
  while (share_slow_steps(slow)) continue;
  for (int prop = 0; prop < num_props(); ++prop) {
    if (!is_awake(prop) || slow[prop] < kSleepSteps) continue;
    const Eigen::Vector3d pos = Eigen::Map<Eigen::Vector3d>(state_.prop_pos_of(env_, prop));
    const Eigen::Vector4d quat = Eigen::Map<Eigen::Vector4d>(state_.prop_quat_of(env_, prop));
    state_.place_prop(env_, prop, pos.data(), quat.data(), PropStatus::kAsleep);
  }
}

bool Physics::Step::share_slow_steps(std::uint8_t* slow) const {
  bool changed = false;
  for (int prop = 0; prop < num_props(); ++prop) {
    for (int other = 0; other < num_props(); ++other) {
      if (slow[prop] <= slow[other] || !is_awake(prop) || !is_awake(other)) continue;
      if (!props_near(prop, other)) continue;
      slow[prop] = slow[other];
      changed = true;
    }
  }
  return changed;
}

// --- gliding kinematic props ---

void Physics::Step::begin_glide(int prop) {
  bench_.gliding.push_back(prop);
  const Eigen::Map<const Eigen::Vector3d> way(state_.prop_qvel_of(env_, prop));
  bench_.centers[at(prop)] += way / 2;
  std::copy_n(state_.prop_pos_of(env_, prop), 3, bench_.motion[at(prop)].qpos);
}

double Physics::Step::reach_of(int prop) const {
  const double radius = prop_model(prop).bounding_radius;
  if (!is_gliding(prop)) return radius;
  return radius + Eigen::Map<const Eigen::Vector3d>(state_.prop_qvel_of(env_, prop)).norm() / 2;
}

bool Physics::Step::gliding_near(int prop) const {
  return std::any_of(bench_.gliding.begin(), bench_.gliding.end(), [&](int other) {
    return prop_model(other).tangible() &&
           spheres_near(bench_.centers[at(prop)], prop_model(prop).bounding_radius,
                        bench_.centers[at(other)], reach_of(other));
  });
}

bool Physics::Step::wake_beside_gliding() {
  bool woken = false;
  for (int prop = 0; prop < num_props(); ++prop) {
    const bool sleeping = is_status(prop, PropStatus::kAsleep) && prop_model(prop).free;
    if (!sleeping || !gliding_near(prop)) continue;
    prepare_awake(prop);
    woken = true;
  }
  return woken;
}

void Physics::Step::glide(double part) {
  for (const int prop : bench_.gliding) {
    double* pos = bench_.motion[at(prop)].qpos;
    const double* from = state_.prop_pos_of(env_, prop);
    const double* way = state_.prop_qvel_of(env_, prop);
    for (int i = 0; i < 3; ++i) pos[i] = from[i] + part * way[i];
    const int mocap = scene_->mocap[at(prop)];
    if (mocap >= 0) std::copy_n(pos, 3, data_->mocap_pos + 3 * mocap);
  }
}

void Physics::Step::store_glides() const {
  for (const int prop : bench_.gliding) {
    std::copy_n(bench_.motion[at(prop)].qpos, 3, state_.prop_pos_of(env_, prop));
    std::fill_n(state_.prop_qvel_of(env_, prop), 6, 0.0);
    state_.prop_status.row(env_)[prop] = static_cast<std::uint8_t>(PropStatus::kAsleep);
  }
}

}  // namespace engram
