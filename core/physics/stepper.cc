#include "core/physics/stepper.h"

namespace engram {
namespace {

// Free rotation is integrated explicitly: a slender prop that tumbles by a radian per substep would
// gain energy from its own gyroscopic torque, without end. rad/s; PhysX's limit for rigid bodies.
constexpr double kFastestSpin = 100;

}  // namespace

Stepper::Workbench::Workbench(const PhysicsModel& model) : bench(model.scenes()) {
  for (const SceneModel& scene : model.scenes()) sieves.emplace_back(*scene.model);
}

int Stepper::first_scene() {
  const bool was_clear = clearance_.is_clear();
  clearance_ = RobotBounds::among(clearance_, waker_.obstacles());
  if (loader_.num_awake() > 0) return loader_.smallest_scene(true);
  // A robot that was among things probably still is.
  return was_clear ? PhysicsModel::kDynamicsScene : PhysicsModel::kRobotScene;
}

bool Stepper::composed_substep(bool first) {
  pose_bodies();
  mark(clock_, StepPart::kDynamics);
  find_scene(first);
  mark(clock_, StepPart::kWake);
  apply_weights();
  mark(clock_, StepPart::kController);
  PairSieve& sieve = workbench_.sieves[at(loader_.scene_index())];
  compose_dynamics(models(sieve.near_pairs(loader_.data())), &loader_.data(), robot_,
                   workbench_.bench, loader_.gliders());
  mark(clock_, StepPart::kDynamics);
  limit_spins();
  return !warned();
}

bool Stepper::plain_substep() {
  pose_bodies();
  apply_weights();
  mark(clock_, StepPart::kController);
  compose_dynamics(models(&loader_.scene_model()), &loader_.data(), robot_, workbench_.bench,
                   loader_.gliders());
  mark(clock_, StepPart::kDynamics);
  limit_spins();
  return !warned();
}

// --- scenes ---

void Stepper::pose_bodies() { compose_kinematics(&loader_.scene_model(), &loader_.data()); }

void Stepper::find_scene(bool first) {
  if (loader_.scene_index() == PhysicsModel::kDynamicsScene) {
    if (robot_is_clear()) return;
    loader_.move_to(PhysicsModel::kRobotScene);
    pose_bodies();
  } else if (loader_.scene_index() == PhysicsModel::kRobotScene && first) {
    // Looked at once per step, for the next one's first_scene(). This step keeps its geometry.
    robot_is_clear();
  }
  while (waker_.wake_what_is_near()) pose_bodies();
}

bool Stepper::robot_is_clear() {
  const RobotBounds& bounds = model_.robot_bounds();
  if (bounds.still_clear(clearance_, loader_.data())) return true;
  clearance_ = bounds.clearance(loader_.data(), waker_.obstacles());
  return clearance_.is_clear();
}

// --- forces ---

StepModels Stepper::models(const mjModel* colliding) const { return {&loader_.scene(), colliding}; }

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
