#include "core/sim/sleep_manager.h"

namespace engram {
namespace {

// Gap below which the robot wakes a sleeping prop. Zero would do: a contact needs touching geoms,
// and the test is made at the configuration that collision is computed for.
constexpr double kWakeGap = 0.002;  // m

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

SleepManager::Workspace::Workspace(const PhysicsModel& model) {
  const std::size_t props = model.props().size();
  frames.resize(props);
  frame_known.resize(props);
  centers.resize(props);
  beyond.resize(props);
  obstacles.reserve(props);
}

void SleepManager::begin() {
  std::fill(workspace_.beyond.begin(), workspace_.beyond.end(), 0.0);
  workspace_.obstacles.clear();
  for (int prop = 0; prop < num_props(); ++prop) locate_remembered(prop);
  locate_gliding();
  for (int prop = 0; prop < num_props(); ++prop) {
    if (!loader_.is_asleep(prop) || !prop_model(prop).tangible()) continue;
    workspace_.obstacles.push_back({workspace_.centers[at(prop)], reach_of(prop) + kWakeGap});
  }
  wake_beside_gliding();
}

// --- where things are ---

void SleepManager::locate(int prop, const double* pos, const double* quat) {
  Frame& frame = workspace_.frames[at(prop)];
  frame = make_frame(pos, quat);
  workspace_.frame_known[at(prop)] = 1;
  workspace_.centers[at(prop)] = frame.pos + frame.axes * prop_model(prop).bounding_center;
}

void SleepManager::locate_remembered(int prop) {
  const double* pos = state_.prop_pos_of(env_, prop);
  if (!prop_model(prop).bounding_center.isZero(0)) {
    locate(prop, pos, state_.prop_quat_of(env_, prop));
    return;
  }
  workspace_.frame_known[at(prop)] = 0;
  workspace_.centers[at(prop)] = Eigen::Map<const Eigen::Vector3d>(pos);
}

void SleepManager::locate_gliding() {
  for (const int prop : loader_.gliding()) {
    const Eigen::Map<const Eigen::Vector3d> way(state_.prop_qvel_of(env_, prop));
    workspace_.centers[at(prop)] += way / 2;
  }
}

double SleepManager::reach_of(int prop) const {
  const double radius = prop_model(prop).bounding_radius;
  if (!loader_.is_gliding(prop)) return radius;
  const double* way = state_.prop_qvel_of(env_, prop);
  return radius + Eigen::Map<const Eigen::Vector3d>(way).norm() / 2;
}

void SleepManager::locate_awake() {
  if (!loader_.scene_has_props()) return;
  for (int prop = 0; prop < num_props(); ++prop) {
    if (!loader_.is_awake(prop)) continue;
    const mjtNum* qpos = loader_.data().qpos + loader_.slot_of(prop).qpos;
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

// --- the robot's reach ---

double SleepManager::lowest_reach() const {
  const mjModel& model = loader_.scene_model();
  const mjData& data = loader_.data();
  double lowest = kFarAway;
  for (const int geom : model_.reach_geoms()) {
    lowest = std::min(lowest, data.geom_xpos[3 * geom + 2] - model.geom_rbound[geom]);
  }
  return lowest;
}

double SleepManager::robot_beyond(int prop, double lowest) const {
  const Eigen::Vector3d& center = workspace_.centers[at(prop)];
  const double radius = reach_of(prop) + kWakeGap;
  const double below = lowest - center.z() - radius;
  if (below > 0) return below;
  const mjData& data = loader_.data();
  double least = kFarAway;
  for (std::size_t i = 0; i < model_.reach_geoms().size() && least > 0; ++i) {
    const int geom = model_.reach_geoms()[i];
    double beyond = sphere_to_geom(loader_.scene_model(), data, geom, center, radius);
    if (beyond <= 0 && !loader_.is_gliding(prop)) {
      beyond = parts_beyond(kWakeGap, std::span(&model_.reach_boxes()[i], 1),
                            geom_frame(data, geom), prop_model(prop).parts, frame_of(prop));
    }
    least = std::min(least, beyond);
  }
  return least;
}

// A prop that was farther away than the robot has moved since need not be looked at again.
bool SleepManager::robot_reaches(int prop, std::optional<double>& lowest) {
  double& beyond = workspace_.beyond[at(prop)];
  if (beyond > 0) return false;
  if (!lowest) lowest = lowest_reach();
  beyond = robot_beyond(prop, *lowest);
  return beyond <= 0;
}

// --- props near one another ---

bool SleepManager::props_near(int prop, int other) const {
  return spheres_near(workspace_.centers[at(prop)], prop_model(prop).bounding_radius,
                      workspace_.centers[at(other)], prop_model(other).bounding_radius) &&
         parts_beyond(kPropWakeGap, prop_model(prop).parts, frame_of(prop), prop_model(other).parts,
                      frame_of(other)) <= 0;
}

bool SleepManager::awake_prop_near(int prop) const {
  for (int other = 0; other < num_props(); ++other) {
    if (loader_.is_awake(other) && props_near(prop, other)) return true;
  }
  return false;
}

bool SleepManager::gliding_near(int prop) const {
  const std::vector<int>& gliding = loader_.gliding();
  return std::any_of(gliding.begin(), gliding.end(), [&](int other) {
    return prop_model(other).tangible() &&
           spheres_near(workspace_.centers[at(prop)], prop_model(prop).bounding_radius,
                        workspace_.centers[at(other)], reach_of(other));
  });
}

void SleepManager::wake_beside_gliding() {
  if (loader_.gliding().empty()) return;
  for (int prop = 0; prop < num_props(); ++prop) {
    const bool sleeping = prop_model(prop).free && loader_.is_asleep(prop);
    if (sleeping && gliding_near(prop)) loader_.wake(prop);
  }
}

// --- waking and sleeping ---

bool SleepManager::wake_touching(const JointArray& qpos) {
  locate_awake();
  const double way = model_.robot_bounds().way(seen_qpos_, qpos);
  seen_qpos_ = qpos;
  std::optional<double> lowest;
  bool kinematic = loader_.scene().has_kinematic_props;
  bool changed = false;
  for (int prop = 0; prop < num_props(); ++prop) {
    if (!loader_.is_asleep(prop) || !prop_model(prop).tangible()) continue;
    const bool free = prop_model(prop).free;
    if (!free && kinematic) continue;
    workspace_.beyond[at(prop)] -= way;
    if (!robot_reaches(prop, lowest) && !(free && awake_prop_near(prop))) continue;
    if (free) loader_.wake(prop);
    kinematic = true;  // awake props meet kinematic ones too
    changed = true;
  }
  if (changed) loader_.enter(loader_.smallest_scene(kinematic));
  return changed;
}

void SleepManager::sleep_resting() {
  if (!loader_.scene_has_props()) return;
  std::uint8_t* slow = state_.prop_slow_steps.row(env_);
  count_slow_steps(slow);
  while (share_slow_steps(slow)) continue;
  for (int prop = 0; prop < num_props(); ++prop) {
    if (!loader_.is_awake(prop) || slow[prop] < kSleepSteps) continue;
    const Eigen::Vector3d pos = Eigen::Map<Eigen::Vector3d>(state_.prop_pos_of(env_, prop));
    const Eigen::Vector4d quat = Eigen::Map<Eigen::Vector4d>(state_.prop_quat_of(env_, prop));
    state_.place_prop(env_, prop, pos.data(), quat.data(), PropStatus::kAsleep);
  }
}

void SleepManager::count_slow_steps(std::uint8_t* slow) const {
  const double lowest = lowest_reach();
  for (int prop = 0; prop < num_props(); ++prop) {
    if (!loader_.is_awake(prop)) continue;
    const bool resting =
        prop_is_static(state_, env_, prop, kSleepLinearSpeed, kSleepAngularSpeed) &&
        robot_beyond(prop, lowest) > 0 && !gliding_near(prop);
    slow[prop] = resting ? static_cast<std::uint8_t>(std::min(slow[prop] + 1, kSleepSteps))
                         : std::uint8_t{0};
  }
}

bool SleepManager::share_slow_steps(std::uint8_t* slow) const {
  bool changed = false;
  for (int prop = 0; prop < num_props(); ++prop) {
    for (int other = 0; other < num_props(); ++other) {
      if (slow[prop] <= slow[other] || !loader_.is_awake(prop) || !loader_.is_awake(other)) {
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
