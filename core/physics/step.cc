#include "core/physics/step.h"

#include <bit>
#include <cmath>
#include <cstdint>

#include "core/physics/composed_step.h"

namespace engram {
namespace {

// Values beyond this are a diverged state, as in MuJoCo's own checks.
constexpr double kLargestValue = mjMAXVAL;

// Free rotation is integrated explicitly: a slender prop that tumbles by a radian per substep would
// gain energy from its own gyroscopic torque, without end. rad/s; PhysX's limit for rigid bodies.
constexpr double kFastestSpin = 100;

// Sleeping and hidden props wait above one another, far from everything.
constexpr double kParkingSpacing = 100.0;  // m

// Without their signs, numbers are ordered as their bits are, and NaN comes last: the top bit of a
// difference tells. The compiler makes vectors of this, as it does not of comparisons.
bool all_plausible(const double* values, int count) {
  constexpr std::uint64_t kSign = std::uint64_t{1} << 63;
  std::uint64_t above = 0;
  for (int i = 0; i < count; ++i) {
    const std::uint64_t magnitude = std::bit_cast<std::uint64_t>(values[i]) & ~kSign;
    above |= std::bit_cast<std::uint64_t>(kLargestValue) - 1 - magnitude;
  }
  return (above & kSign) == 0;
}

int count_warnings(const mjData& data) {
  int count = 0;
  for (const mjWarningStat& warning : data.warning) count += warning.number;
  return count;
}

}  // namespace

bool Physics::Step::plausible() const {
  const int count = num_props();
  return all_plausible(state_.qpos.row(env_), kRobotJoints) &&
         all_plausible(state_.qvel.row(env_), kRobotJoints) &&
         all_plausible(state_.prop_pos.row(env_), 3 * count) &&
         all_plausible(state_.prop_quat.row(env_), 4 * count) &&
         all_plausible(state_.prop_qvel.row(env_), 6 * count) &&
         all_plausible(state_.prop_qacc_warmstart.row(env_), 6 * count);
}

bool Physics::Step::run() {
  if (!plausible()) return false;
  begin();
  for (int i = 0; i < options_.substeps; ++i) {
    glide(static_cast<double>(i + 1) / options_.substeps);
    mark(clock_, StepPart::kGather);
    if (options_.sleep) {
      composed_substep();
    } else {
      plain_substep();
    }
    limit_spins();
    if (count_warnings(*data_) != 0) return false;
  }
  if (!all_plausible(data_->qpos, scene_->model->nq) ||
      !all_plausible(data_->qvel, scene_->model->nv)) {
    return false;
  }
  store();
  mark(clock_, StepPart::kGather);
  if (options_.sleep && scene_index_ > PhysicsModel::kRobotScene) put_to_sleep();
  mark(clock_, StepPart::kWake);
  return true;
}

// --- choosing and loading scenes ---

void Physics::Step::begin() {
  std::fill(bench_.awake_by_type.begin(), bench_.awake_by_type.end(), 0);
  bench_.obstacles.clear();
  bench_.gliding.clear();
  std::fill(bench_.beyond.begin(), bench_.beyond.end(), 0.0);
  bool any_awake = false;
  for (int prop = 0; prop < num_props(); ++prop) {
    PropStatus status = state_.status_of(env_, prop);
    locate_remembered(prop);
    if (status == PropStatus::kAsleep && !options_.sleep && prop_model(prop).free) {
      status = PropStatus::kAwake;
    }
    if (status == PropStatus::kAwake && !prop_model(prop).free) {
      status = PropStatus::kAsleep;
      begin_glide(prop);
    }
    bench_.status[at(prop)] = static_cast<std::uint8_t>(status);
    if (status == PropStatus::kAwake) {
      prepare_awake(prop);
      any_awake = true;
    } else if (status == PropStatus::kAsleep && prop_model(prop).tangible()) {
      bench_.obstacles.push_back({bench_.centers[at(prop)], reach_of(prop) + kWakeGap});
    }
  }
  any_awake |= wake_beside_gliding();
  // A robot that was among things is taken to be there still; composed_substep() looks.
  int scene = clearance_.is_clear() ? PhysicsModel::kDynamicsScene : PhysicsModel::kRobotScene;
  clearance_ = RobotBounds::among(clearance_, bench_.obstacles);
  if (any_awake) scene = model_.smallest_scene(bench_.awake_by_type, true);
  if (!options_.sleep) scene = model_.full_scene();
  enter(scene, state_.qpos.row(env_), state_.qvel.row(env_), state_.qacc_warmstart.row(env_));
}

void Physics::Step::prepare_awake(int prop) {
  bench_.status[at(prop)] = static_cast<std::uint8_t>(PropStatus::kAwake);
  ++bench_.awake_by_type[at(prop_model(prop).type)];
  PropMotion& motion = bench_.motion[at(prop)];
  std::copy_n(state_.prop_pos_of(env_, prop), 3, motion.qpos);
  std::copy_n(state_.prop_quat_of(env_, prop), 4, motion.qpos + 3);
  std::copy_n(state_.prop_qvel_of(env_, prop), 6, motion.qvel);
  std::copy_n(state_.prop_qacc_warmstart.row(env_) + 6 * prop, 6, motion.qacc_warmstart);
}

void Physics::Step::enter(int scene, const double* qpos, const double* qvel,
                          const double* warmstart) {
  scene_index_ = scene;
  scene_ = &model_.scenes()[at(scene)];
  data_ = bench_.scenes[at(scene)].get();
  std::copy_n(qpos, kRobotJoints, data_->qpos);
  std::copy_n(qvel, kRobotJoints, data_->qvel);
  std::copy_n(warmstart, kRobotJoints, data_->qacc_warmstart);
  if (scene <= PhysicsModel::kRobotScene) return;
  load_kinematic_props();
  load_free_props();
}

void Physics::Step::move_to(int scene) {
  harvest();
  enter(scene, data_->qpos, data_->qvel, data_->qacc_warmstart);
}

void Physics::Step::load_kinematic_props() {
  for (int prop = 0; prop < num_props(); ++prop) {
    const int mocap = scene_->mocap[at(prop)];
    if (mocap < 0) continue;
    const double parked[3] = {0, 0, -kParkingSpacing * (prop + 1)};
    const bool present = !is_status(prop, PropStatus::kHidden);
    const double* pos =
        is_gliding(prop) ? bench_.motion[at(prop)].qpos : state_.prop_pos_of(env_, prop);
    std::copy_n(present ? pos : parked, 3, data_->mocap_pos + 3 * mocap);
    std::copy_n(state_.prop_quat_of(env_, prop), 4, data_->mocap_quat + 4 * mocap);
  }
}

void Physics::Step::load_free_props() {
  int slot = 0;
  const int count = static_cast<int>(scene_->slots.size());
  while (slot < count) {
    const int type = scene_->slots[at(slot)].type;
    for (int prop = 0; prop < num_props(); ++prop) {
      if (!is_awake(prop) || prop_model(prop).type != type) continue;
      bench_.slot[at(prop)] = slot;
      load_slot(slot++, bench_.motion[at(prop)]);
    }
    for (; slot < count && scene_->slots[at(slot)].type == type; ++slot) {
      const PropMotion parked{{0, 0, kParkingSpacing * (slot + 1), 1, 0, 0, 0}, {}, {}};
      load_slot(slot, parked);
    }
  }
}

void Physics::Step::load_slot(int slot, const PropMotion& motion) const {
  const PropSlot& where = scene_->slots[at(slot)];
  std::copy_n(motion.qpos, 7, data_->qpos + where.qpos);
  std::copy_n(motion.qvel, 6, data_->qvel + where.dof);
  std::copy_n(motion.qacc_warmstart, 6, data_->qacc_warmstart + where.dof);
  std::fill_n(data_->qfrc_applied + where.dof, 6, 0.0);
}

void Physics::Step::harvest() {
  if (scene_index_ <= PhysicsModel::kRobotScene) return;
  for (int prop = 0; prop < num_props(); ++prop) {
    if (!is_awake(prop)) continue;
    const PropSlot& where = slot_of(prop);
    PropMotion& motion = bench_.motion[at(prop)];
    std::copy_n(data_->qpos + where.qpos, 7, motion.qpos);
    std::copy_n(data_->qvel + where.dof, 6, motion.qvel);
    std::copy_n(data_->qacc_warmstart + where.dof, 6, motion.qacc_warmstart);
  }
}

// --- substeps ---

void Physics::Step::apply_weights() const {
  for (int prop = 0; prop < num_props(); ++prop) {
    if (!is_awake(prop)) continue;
    const PropModel& about = prop_model(prop);
    const PropSlot& where = slot_of(prop);
    const mjtNum* quat = data_->qpos + where.qpos + 3;
    const Eigen::Vector3d weight(0, 0, -about.mass * model_.gravity());
    const Eigen::Vector3d in_body =
        Eigen::Quaterniond(quat[0], quat[1], quat[2], quat[3]).conjugate() * weight;
    Eigen::Map<Eigen::Vector3d>(data_->qfrc_applied + where.dof) = weight;
    Eigen::Map<Eigen::Vector3d>(data_->qfrc_applied + where.dof + 3) =
        about.center_of_mass.cross(in_body);
  }
}

void Physics::Step::limit_spins() const {
  if (scene_index_ <= PhysicsModel::kRobotScene) return;
  for (int prop = 0; prop < num_props(); ++prop) {
    if (!is_awake(prop)) continue;
    Eigen::Map<Eigen::Vector3d> spin(data_->qvel + slot_of(prop).dof + 3);
    const double speed = spin.norm();
    if (speed > kFastestSpin) spin *= kFastestSpin / speed;
  }
}

void Physics::Step::plain_substep() const {
  apply_drive(model_.drive_law(), drive_, *data_);
  apply_weights();
  mark(clock_, StepPart::kController);
  mj_step(scene_->model.get(), data_);
  mark(clock_, StepPart::kDynamics);
}

bool Physics::Step::robot_is_clear() {
  const RobotBounds& bounds = model_.robot_bounds();
  if (bounds.still_clear(clearance_, *data_)) return true;
  clearance_ = bounds.clearance(*data_, bench_.obstacles);
  return clearance_.is_clear();
}

void Physics::Step::composed_substep() {
  compose_kinematics(scene_->model.get(), data_);
  mark(clock_, StepPart::kDynamics);
  if (scene_index_ == PhysicsModel::kDynamicsScene && !robot_is_clear()) {
    move_to(PhysicsModel::kRobotScene);
    compose_kinematics(scene_->model.get(), data_);
  } else if (scene_index_ == PhysicsModel::kRobotScene && !looked_) {
    robot_is_clear();  // for the next step
  }
  looked_ = true;
  if (scene_index_ != PhysicsModel::kDynamicsScene) {
    while (wake_what_is_near()) compose_kinematics(scene_->model.get(), data_);
  }
  mark(clock_, StepPart::kWake);
  apply_drive(model_.drive_law(), drive_, *data_);
  if (scene_index_ > PhysicsModel::kRobotScene) apply_weights();
  mark(clock_, StepPart::kController);
  PairSieve& sieve = bench_.sieves[at(scene_index_)];
  compose_dynamics(scene_->model.get(), data_, sieve.near_pairs(*data_));
  mark(clock_, StepPart::kDynamics);
}

// --- storing ---

void Physics::Step::store() {
  std::copy_n(data_->qpos, kRobotJoints, state_.qpos.row(env_));
  std::copy_n(data_->qvel, kRobotJoints, state_.qvel.row(env_));
  std::copy_n(data_->qacc_warmstart, kRobotJoints, state_.qacc_warmstart.row(env_));
  if (num_props() == 0) return;
  store_glides();
  std::fill_n(state_.finger_force.row(env_), 6 * num_props(), 0.0);
  if (scene_index_ <= PhysicsModel::kRobotScene) return;
  harvest();
  for (int prop = 0; prop < num_props(); ++prop) {
    if (!is_awake(prop)) continue;
    const PropMotion& motion = bench_.motion[at(prop)];
    std::copy_n(motion.qpos, 3, state_.prop_pos_of(env_, prop));
    std::copy_n(motion.qpos + 3, 4, state_.prop_quat_of(env_, prop));
    std::copy_n(motion.qvel, 6, state_.prop_qvel_of(env_, prop));
    std::copy_n(motion.qacc_warmstart, 6, state_.prop_qacc_warmstart.row(env_) + 6 * prop);
    state_.prop_status.row(env_)[prop] = bench_.status[at(prop)];
  }
  store_finger_forces();
}

void Physics::Step::store_finger_forces() const {
  const mjModel& model = *scene_->model;
  for (int i = 0; i < data_->ncon; ++i) {
    const mjContact& contact = data_->contact[i];
    if (contact.efc_address < 0) continue;
    const int bodies[2] = {model.geom_bodyid[contact.geom1], model.geom_bodyid[contact.geom2]};
    const int slot =
        std::max(scene_->slot_of_body[at(bodies[0])], scene_->slot_of_body[at(bodies[1])]);
    const int prop = slot < 0 ? -1 : prop_in_slot(slot);
    for (int finger = 0; finger < kFingers && prop >= 0; ++finger) {
      const int body = model_.finger_bodies()[finger];
      if (body != bodies[0] && body != bodies[1]) continue;
      mjtNum wrench[6];  // in the contact's frame, on the second body
      mj_contactForce(&model, data_, i, wrench);
      const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> frame(contact.frame);
      const Eigen::Vector3d force =
          frame.transpose() * Eigen::Vector3d(wrench[0], wrench[1], wrench[2]);
      Eigen::Map<Eigen::Vector3d> sum(state_.finger_force.row(env_) + 6 * prop + 3 * finger);
      sum += body == bodies[1] ? force : Eigen::Vector3d(-force);
    }
  }
}

int Physics::Step::prop_in_slot(int slot) const {
  int prop = num_props() - 1;
  while (prop >= 0 && (!is_awake(prop) || bench_.slot[at(prop)] != slot)) --prop;
  return prop;
}

}  // namespace engram
