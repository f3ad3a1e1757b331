#include "core/sim/sleep_manager.h"

namespace engram {
namespace {

// Gap below which the robot wakes a sleeping prop. Zero would suffice: a contact needs touching
// geoms, and the test is made at the configuration of collision detection.
constexpr double kWakeGap = 0.002;  // m

// Gap below which props wake one another; they may stand a millimetre apart and sleep.
constexpr double kPropWakeGap = 0.0005;  // m

// A free prop that is slower than this for so many control steps, with nothing in motion near it,
// falls asleep.
constexpr double kSleepLinearSpeed = 0.005;  // m/s
constexpr double kSleepAngularSpeed = 0.05;  // rad/s
constexpr int kSleepSteps = 5;

bool spheres_near(const Eigen::Vector3d& a, double radius_a, const Eigen::Vector3d& b,
                  double radius_b) {
  const double reach = radius_a + radius_b + kPropWakeGap;
  return (a - b).squaredNorm() <= reach * reach;
}

}  // namespace

SleepWorkspace::SleepWorkspace(const PhysicsModel& model) {
  const std::size_t props = model.props().size();
  frames.resize(props);
  frame_known.resize(props);
  centers.resize(props);
  clearance.resize(props);
  obstacles.reserve(props);
}

void SleepManager::begin() {
  std::fill(workspace_.clearance.begin(), workspace_.clearance.end(), 0.0);
  workspace_.obstacles.clear();
  for (int prop = 0; prop < num_props(); ++prop) locate_stored(prop);
  locate_moving();
  for (int prop = 0; prop < num_props(); ++prop) {
    if (!step_.is_asleep(prop) || !prop_model(prop).tangible()) continue;
    workspace_.obstacles.push_back({workspace_.centers[at(prop)], swept_radius(prop) + kWakeGap});
  }
  wake_near_moving_props();
}

// --- positions of props ---

void SleepManager::locate(int prop, const double* pos, const double* quat) {
  Frame& frame = workspace_.frames[at(prop)];
  frame = make_frame(pos, quat);
  workspace_.frame_known[at(prop)] = 1;
  workspace_.centers[at(prop)] = frame.pos + frame.axes * prop_model(prop).bounding_center;
}

void SleepManager::locate_stored(int prop) {
  const double* pos = state_.prop_pos_of(env_, prop);
  if (!prop_model(prop).bounding_center.isZero(0)) {
    locate(prop, pos, state_.prop_quat_of(env_, prop));
    return;
  }
  workspace_.frame_known[at(prop)] = 0;
  workspace_.centers[at(prop)] = Eigen::Map<const Eigen::Vector3d>(pos);
}

void SleepManager::locate_moving() {
  for (const int prop : step_.moving()) {
    const Eigen::Map<const Eigen::Vector3d> displacement(step_.displacement_of(prop));
    workspace_.centers[at(prop)] += displacement / 2;
  }
}

double SleepManager::swept_radius(int prop) const {
  const double radius = prop_model(prop).bounding_radius;
  if (!step_.is_moving(prop)) return radius;
  return radius + Eigen::Map<const Eigen::Vector3d>(step_.displacement_of(prop)).norm() / 2;
}

void SleepManager::locate_awake() {
  if (!step_.scene_has_props()) return;
  for (int prop = 0; prop < num_props(); ++prop) {
    if (!step_.is_awake(prop)) continue;
    const mjtNum* qpos = step_.data().qpos + step_.slot_of(prop).qpos;
    locate(prop, qpos, qpos + 3);
  }
}

const Frame& SleepManager::frame_of(int prop) const {
  Frame& frame = workspace_.frames[at(prop)];
  if (workspace_.frame_known[at(prop)] == 0) {
    frame = make_frame(state_.prop_pos_of(env_, prop), state_.prop_quat_of(env_, prop));
    workspace_.frame_known[at(prop)] = 1;
  }
  return frame;
}

// --- distances to the robot ---

double SleepManager::lowest_reach() const {
  const mjModel& model = step_.scene_model();
  const mjData& data = step_.data();
  double lowest = kFarAway;
  for (const int geom : step_.model.reach_geoms()) {
    lowest = std::min(lowest, data.geom_xpos[3 * geom + 2] - model.geom_rbound[geom]);
  }
  return lowest;
}

double SleepManager::robot_clearance(int prop, double lowest) const {
  const Eigen::Vector3d& center = workspace_.centers[at(prop)];
  const double radius = swept_radius(prop) + kWakeGap;
  const double below = lowest - center.z() - radius;
  if (below > 0) return below;
  const mjData& data = step_.data();
  double least = kFarAway;
  for (std::size_t i = 0; i < step_.model.reach_geoms().size() && least > 0; ++i) {
    const int geom = step_.model.reach_geoms()[i];
    double clearance = sphere_geom_clearance(step_.scene_model(), data, geom, center, radius);
    if (clearance <= 0 && !step_.is_moving(prop)) {
      clearance = parts_clearance(kWakeGap, std::span(&step_.model.reach_boxes()[i], 1),
                                  geom_frame(data, geom), prop_model(prop).parts, frame_of(prop));
    }
    least = std::min(least, clearance);
  }
  return least;
}

// Skips props that were farther away than the robot has moved since.
bool SleepManager::robot_reaches(int prop, std::optional<double>& lowest) {
  double& clearance = workspace_.clearance[at(prop)];
  if (clearance > 0) return false;
  if (!lowest) lowest = lowest_reach();
  clearance = robot_clearance(prop, *lowest);
  return clearance <= 0;
}

// --- distances between props ---

bool SleepManager::props_near(int prop, int other) const {
  return spheres_near(workspace_.centers[at(prop)], prop_model(prop).bounding_radius,
                      workspace_.centers[at(other)], prop_model(other).bounding_radius) &&
         parts_clearance(kPropWakeGap, prop_model(prop).parts, frame_of(prop),
                         prop_model(other).parts, frame_of(other)) <= 0;
}

bool SleepManager::awake_prop_near(int prop) const {
  for (int other = 0; other < num_props(); ++other) {
    if (step_.is_awake(other) && props_near(prop, other)) return true;
  }
  return false;
}

bool SleepManager::moving_prop_near(int prop) const {
  const std::vector<int>& moving = step_.moving();
  return std::any_of(moving.begin(), moving.end(), [&](int other) {
    return prop_model(other).tangible() &&
           spheres_near(workspace_.centers[at(prop)], prop_model(prop).bounding_radius,
                        workspace_.centers[at(other)], swept_radius(other));
  });
}

void SleepManager::wake_near_moving_props() {
  if (step_.moving().empty()) return;
  for (int prop = 0; prop < num_props(); ++prop) {
    const bool sleeping = prop_model(prop).free && step_.is_asleep(prop);
    if (sleeping && moving_prop_near(prop)) step_.wake(prop);
  }
}

// --- waking and sleeping ---

std::optional<int> SleepManager::wake_touching(const JointArray& qpos) {
  locate_awake();
  const double displacement = step_.model.robot_bounds().max_displacement(checked_qpos_, qpos);
  checked_qpos_ = qpos;
  std::optional<double> lowest;
  bool kinematic = step_.scene->has_kinematic_props;
  bool changed = false;
  for (int prop = 0; prop < num_props(); ++prop) {
    if (!step_.is_asleep(prop) || !prop_model(prop).tangible()) continue;
    const bool free = prop_model(prop).free;
    if (!free && kinematic) continue;
    workspace_.clearance[at(prop)] -= displacement;
    if (!robot_reaches(prop, lowest) && !(free && awake_prop_near(prop))) continue;
    if (free) step_.wake(prop);
    kinematic = true;  // awake props may touch kinematic ones too
    changed = true;
  }
  if (!changed) return std::nullopt;
  return step_.smallest_scene(kinematic);
}

void SleepManager::sleep_resting() {
  if (!step_.scene_has_props()) return;
  std::uint8_t* slow = state_.prop_slow_steps.row(env_);
  count_slow_steps(slow);
  while (share_slow_steps(slow)) continue;
  for (int prop = 0; prop < num_props(); ++prop) {
    if (!step_.is_awake(prop) || slow[prop] < kSleepSteps) continue;
    const Eigen::Vector3d pos = Eigen::Map<Eigen::Vector3d>(state_.prop_pos_of(env_, prop));
    const Eigen::Vector4d quat = Eigen::Map<Eigen::Vector4d>(state_.prop_quat_of(env_, prop));
    state_.place_prop(env_, prop, pos.data(), quat.data(), PropStatus::kAsleep);
  }
}

void SleepManager::count_slow_steps(std::uint8_t* slow) const {
  const double lowest = lowest_reach();
  for (int prop = 0; prop < num_props(); ++prop) {
    if (!step_.is_awake(prop)) continue;
    const bool resting =
        prop_is_static(state_, env_, prop, kSleepLinearSpeed, kSleepAngularSpeed) &&
        robot_clearance(prop, lowest) > 0 && !moving_prop_near(prop);
    slow[prop] = resting ? static_cast<std::uint8_t>(std::min(slow[prop] + 1, kSleepSteps))
                         : std::uint8_t{0};
  }
}

bool SleepManager::share_slow_steps(std::uint8_t* slow) const {
  bool changed = false;
  for (int prop = 0; prop < num_props(); ++prop) {
    for (int other = 0; other < num_props(); ++other) {
      if (slow[prop] <= slow[other] || !step_.is_awake(prop) || !step_.is_awake(other)) {
        continue;
      }
      if (!props_near(prop, other)) continue;
      slow[prop] = slow[other];
      changed = true;
    }
  }
  return changed;
}

}  // namespace engram
