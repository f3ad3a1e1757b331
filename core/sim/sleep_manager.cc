#include "core/sim/sleep_manager.h"

#include "core/scene/speculative_margin.h"

namespace engram {
namespace {

// Gap below which the robot wakes a sleeping prop at rest, and at most; the displacement of a
// substep is added to it, since contacts act before bodies touch.
constexpr double kMinWakeGap = 0.006;  // m
constexpr double kWakeGap = kContactMargin;

// Gap below which props wake one another; they may stand a millimetre apart and sleep.
constexpr double kPropWakeGap = 0.0005;  // m

// A free prop that is slower than this for kSleepSteps control steps, with nothing in motion near
// it, falls asleep.
constexpr double kSleepLinearSpeed = 0.005;  // m/s
constexpr double kSleepAngularSpeed = 0.05;  // rad/s
// As good is a mean speed below this: the last iteration of the contact law leaves velocities that
// no position follows, and stacks vibrate by micrometres. Stacks that creep in the original are
// faster.
constexpr double kStillLinearSpeed = 1.5e-4;  // m/s
constexpr double kStillAngularSpeed = 2e-3;   // rad/s
constexpr int kSleepSteps = 5;

bool spheres_near(const Eigen::Vector3d& a, double radius_a, const Eigen::Vector3d& b,
                  double radius_b, double gap) {
  const double reach = radius_a + radius_b + gap;
  return (a - b).squaredNorm() <= reach * reach;
}

}  // namespace

SleepWorkspace::SleepWorkspace(const PhysicsModel& model) {
  const std::size_t props = model.props().size();
  frames.resize(props);
  frame_known.resize(props);
  centers.resize(props);
  clearance.resize(props);
  approach.resize(props);
  obstacles.reserve(props);
}

void SleepManager::begin(int substeps) {
  std::fill(workspace_.clearance.begin(), workspace_.clearance.end(), 0.0);
  workspace_.obstacles.clear();
  for (int prop = 0; prop < num_props(); ++prop) locate_stored(prop);
  locate_moving();
  for (int prop = 0; prop < num_props(); ++prop) {
    if (!step_.is_asleep(prop) || !prop_model(prop).tangible()) continue;
    double radius = swept_radius(prop) + kWakeGap;
    if (step_.is_moving(prop)) {
      radius += kSpeculativeFactor * displacement(prop).norm() / substeps;
    }
    workspace_.obstacles.push_back({workspace_.centers[at(prop)], radius});
  }
  wake_near_moving_props();
}

// --- positions of props ---

void SleepManager::locate_stored(int prop) {
  const Vec3& center = prop_model(prop).bounding_center;
  workspace_.frame_known[at(prop)] = 0;
  workspace_.centers[at(prop)] = Eigen::Map<const Vec3>(state_.prop_pos_of(env_, prop));
  if (center.isZero(0)) return;
  const Frame& frame = frame_of(prop);
  workspace_.centers[at(prop)] = frame.pos + frame.axes * center;
}

void SleepManager::locate_moving() {
  for (const int prop : step_.moving()) {
    workspace_.centers[at(prop)] += displacement(prop) / 2;
  }
}

Eigen::Map<const Eigen::Vector3d> SleepManager::displacement(int prop) const {
  return Eigen::Map<const Eigen::Vector3d>(step_.displacement_of(prop));
}

double SleepManager::swept_radius(int prop) const {
  const double radius = prop_model(prop).bounding_radius;
  if (!step_.is_moving(prop)) return radius;
  return radius + displacement(prop).norm() / 2;
}

void SleepManager::locate_awake() {
  for (const int prop : step_.awake()) {
    const FreeBodyState& motion = step_.workspace.motion[at(prop)];
    Frame& frame = workspace_.frames[at(prop)];
    frame.axes = motion.quat.toRotationMatrix();
    frame.pos = motion.center - frame.axes * prop_model(prop).body.center();
    workspace_.frame_known[at(prop)] = 1;
    workspace_.centers[at(prop)] = frame.pos + frame.axes * prop_model(prop).bounding_center;
    workspace_.approach[at(prop)] =
        kSpeculativeFactor * step_.model.robot_params().timestep * step_.prop_speed(prop);
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

void SleepManager::pose_reach() {
  if (reach_known_) return;
  reach_known_ = true;
  const CollisionScene& scene = step_.model.collision();
  for (std::size_t i = 0; i < step_.model.reach_shapes().size(); ++i) {
    const CollisionShape& shape = scene.shapes()[at(step_.model.reach_shapes()[i])];
    const Frame& body = step_.workspace.bodies.frames[at(shape.body)];
    step_.workspace.reach_frames[i] = {body.pos + body.axes * shape.frame.pos,
                                       body.axes * shape.frame.axes};
    const double approach = kSpeculativeFactor * step_.model.robot_params().timestep *
                            step_.workspace.bodies.speeds[at(shape.body)];
    step_.workspace.reach_gaps[i] = std::min(kWakeGap, kMinWakeGap + approach);
  }
}

double SleepManager::lowest_reach() const {
  double lowest = kFarAway;
  for (std::size_t i = 0; i < step_.model.reach_shapes().size(); ++i) {
    const int shape = step_.model.reach_shapes()[i];
    lowest = std::min(lowest, step_.workspace.reach_frames[i].pos.z() -
                                  step_.model.collision().shapes()[at(shape)].bounding_radius);
  }
  return lowest;
}

double SleepManager::robot_clearance(int prop, double lowest, Gaps gaps, std::size_t& first) const {
  const Eigen::Vector3d& center = workspace_.centers[at(prop)];
  const double radius = swept_radius(prop);
  const double below = lowest - center.z() - radius - kWakeGap;
  if (below > 0) return below;
  const std::vector<int>& reach = step_.model.reach_shapes();
  const std::vector<CollisionShape>& shapes = step_.model.collision().shapes();
  double least = kFarAway;
  for (std::size_t i = first; i < reach.size() && least > 0; ++i) {
    first = i;
    const CollisionShape& shape = shapes[at(reach[i])];
    const Frame& frame = step_.workspace.reach_frames[i];
    const double gap = gaps == Gaps::kLargest ? kWakeGap : step_.workspace.reach_gaps[i];
    double clearance = sphere_clearance(shape, frame, center, radius + gap);
    if (clearance <= 0 && !step_.is_moving(prop)) {
      clearance = parts_clearance(gap, std::span(&step_.model.reach_boxes()[i], 1), frame,
                                  prop_model(prop).parts, frame_of(prop));
    }
    least = std::min(least, clearance);
  }
  return least;
}

// Skips props that were farther away than the robot has moved since.
bool SleepManager::robot_reaches(int prop, std::optional<double>& lowest) {
  double& clearance = workspace_.clearance[at(prop)];
  if (clearance > 0) return false;
  if (!lowest) {
    pose_reach();
    lowest = lowest_reach();
  }
  // Parts that are farther than the largest gap are farther than their own.
  std::size_t first = 0;
  clearance = robot_clearance(prop, *lowest, Gaps::kLargest, first);
  return clearance <= 0 && robot_clearance(prop, *lowest, Gaps::kBySpeed, first) <= 0;
}

// --- distances between props ---

bool SleepManager::props_near(int prop, int other, double gap) const {
  return spheres_near(workspace_.centers[at(prop)], prop_model(prop).bounding_radius,
                      workspace_.centers[at(other)], prop_model(other).bounding_radius, gap) &&
         parts_clearance(gap, prop_model(prop).parts, frame_of(prop), prop_model(other).parts,
                         frame_of(other)) <= 0;
}

bool SleepManager::awake_prop_near(int prop) const {
  return std::any_of(step_.awake().begin(), step_.awake().end(), [&](int other) {
    return props_near(prop, other, kPropWakeGap + workspace_.approach[at(other)]);
  });
}

bool SleepManager::moving_prop_near(int prop) const {
  const std::vector<int>& moving = step_.moving();
  return std::any_of(moving.begin(), moving.end(), [&](int other) {
    return prop_model(other).tangible() &&
           spheres_near(workspace_.centers[at(prop)], prop_model(prop).bounding_radius,
                        workspace_.centers[at(other)], swept_radius(other), kPropWakeGap);
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

void SleepManager::wake_touching(const RobotPose& robot) {
  locate_awake();
  reach_known_ = false;
  const double moved = step_.model.robot_bounds().max_displacement(checked_qpos_, robot.qpos);
  checked_qpos_ = robot.qpos;
  std::optional<double> lowest;
  for (int prop = 0; prop < num_props(); ++prop) workspace_.clearance[at(prop)] -= moved;
  for (bool changed = true; changed;) {
    changed = false;
    for (int prop = 0; prop < num_props(); ++prop) {
      if (!step_.is_asleep(prop) || !prop_model(prop).free) continue;
      if (!robot_reaches(prop, lowest) && !awake_prop_near(prop)) continue;
      step_.wake(prop);
      locate_awake();
      changed = true;
    }
  }
}

bool SleepManager::is_slow(int prop) const {
  const FreeBodyState& now = step_.workspace.motion[at(prop)];
  if (now.linear.norm() <= kSleepLinearSpeed && now.angular.norm() <= kSleepAngularSpeed) {
    return true;
  }
  const FreeBodyState& before = step_.workspace.begin[at(prop)];
  const double per_second = step_.workspace.moves_per_second;
  // Sine of half the angle, which is small.
  const double half_turn = (before.quat.conjugate() * now.quat).vec().norm();
  return per_second * (now.center - before.center).norm() <= kStillLinearSpeed &&
         2 * per_second * half_turn <= kStillAngularSpeed;
}

void SleepManager::count_slow_steps() {
  if (step_.awake().empty()) return;
  std::uint8_t* slow = state_.prop_slow_steps.row(env_);
  pose_reach();
  const double lowest = lowest_reach();
  for (const int prop : step_.awake()) {
    std::size_t first = 0;
    const bool resting = is_slow(prop) &&
                         robot_clearance(prop, lowest, Gaps::kBySpeed, first) > 0 &&
                         !moving_prop_near(prop);
    slow[prop] = resting ? static_cast<std::uint8_t>(std::min(slow[prop] + 1, kSleepSteps))
                         : std::uint8_t{0};
  }
  while (share_slow_steps(slow)) continue;
}

void SleepManager::sleep_resting() {
  std::uint8_t* slow = state_.prop_slow_steps.row(env_);
  for (const int prop : step_.awake()) {
    if (slow[prop] < kSleepSteps) continue;
    std::fill_n(state_.prop_qvel_of(env_, prop), 6, 0.0);
    state_.prop_status.row(env_)[prop] = static_cast<std::uint8_t>(PropStatus::kAsleep);
    slow[prop] = 0;
  }
}

bool SleepManager::share_slow_steps(std::uint8_t* slow) const {
  bool changed = false;
  for (int prop = 0; prop < num_props(); ++prop) {
    for (int other = 0; other < num_props(); ++other) {
      if (slow[prop] <= slow[other] || !step_.is_awake(prop) || !step_.is_awake(other)) {
        continue;
      }
      if (!props_near(prop, other, kPropWakeGap)) continue;
      slow[prop] = slow[other];
      changed = true;
    }
  }
  return changed;
}

}  // namespace engram
