#include "core/sim/stepper.h"

namespace engram {
namespace {

// Free rotation is integrated explicitly: a slender prop that tumbles by a radian per substep would
// gain energy from its own gyroscopic torque, without end. rad/s; PhysX's limit for rigid bodies.
constexpr double kFastestSpin = 100;

}  // namespace

int Stepper::first_scene() {
  const bool was_clear = clearance_.is_clear();
  clearance_ = RobotBounds::among(clearance_, waker_.obstacles());
  if (loader_.num_awake() > 0) return loader_.smallest_scene(true);
  // A robot that was among things probably still is.
  return was_clear ? PhysicsModel::kDynamicsScene : PhysicsModel::kRobotScene;
}

void Stepper::look_around(const RobotPose& pose) {
  looked_ = true;
  clearance_ = model_.robot_bounds().clearance(pose, waker_.obstacles());
  if (!is_busy() && !clearance_.is_clear()) loader_.enter(PhysicsModel::kRobotScene);
}

bool Stepper::substep(const RobotPose& pose, bool sleep, LaneBlock& block, int lane) {
  robot_.load(block.rows(), block.lanes(), lane);
  load(pose);
  mark(clock_, StepPart::kDynamics);
  const mjModel* colliding = &loader_.scene_model();
  if (sleep) {
    // For the next step's first_scene(). This one keeps its geometry.
    if (loader_.scene_index() == PhysicsModel::kRobotScene && !looked_) look_around(pose);
    while (waker_.wake_touching(pose.qpos)) load(pose);
    mark(clock_, StepPart::kWake);
    colliding = loader_.sieve().near_pairs(loader_.data());
  }
  apply_weights();
  mark(clock_, StepPart::kController);
  contact_step({&loader_.scene(), colliding}, &loader_.data(), robot_, loader_.contact_workspace(),
               loader_.gliders());
  block.put(LaneRows::kEndQ, lane, robot_.end_q().data(), kRobotJoints);
  block.put(LaneRows::kEndV, lane, robot_.end_v().data(), kRobotJoints);
  limit_spins();
  loader_.harvest();
  mark(clock_, StepPart::kDynamics);
  return !warned();
}

void Stepper::load(const RobotPose& pose) {
  loader_.load(pose.qpos, robot_.v);
  loader_.scene().kinematics.pose(pose, loader_.data());
}

// --- forces ---

void Stepper::apply_weights() const {
  if (!loader_.scene_has_props()) return;
  mjData& data = loader_.data();
  for (int prop = 0; prop < loader_.num_props(); ++prop) {
    if (!loader_.is_awake(prop)) continue;
    const PropModel& about = loader_.prop_model(prop);
    const PropSlot& where = loader_.slot_of(prop);
    const mjtNum* quat = data.qpos + where.qpos + 3;
    const Eigen::Vector3d weight(0, 0, -about.mass * model_.gravity());
    const Eigen::Vector3d in_body =
        Eigen::Quaterniond(quat[0], quat[1], quat[2], quat[3]).conjugate() * weight;
    Eigen::Map<Eigen::Vector3d>(data.qfrc_applied + where.dof) = weight;
    Eigen::Map<Eigen::Vector3d>(data.qfrc_applied + where.dof + 3) =
        about.center_of_mass.cross(in_body);
  }
}

void Stepper::limit_spins() const {
  if (!loader_.scene_has_props()) return;
  for (int prop = 0; prop < loader_.num_props(); ++prop) {
    if (!loader_.is_awake(prop)) continue;
    Eigen::Map<Eigen::Vector3d> spin(loader_.data().qvel + loader_.slot_of(prop).dof + 3);
    const double speed = spin.norm();
    if (speed > kFastestSpin) spin *= kFastestSpin / speed;
  }
}

bool Stepper::warned() const {
  const mjData& data = loader_.data();
  return std::any_of(std::begin(data.warning), std::end(data.warning),
                     [](const mjWarningStat& warning) { return warning.number != 0; });
}

}  // namespace engram
