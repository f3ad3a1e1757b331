#include "core/sim/scene_binding.h"

#include <bit>

namespace engram {
namespace {

// Values beyond this are a diverged state, as in MuJoCo's own checks.
constexpr double kLargestValue = mjMAXVAL;

// Spacing of empty slots and hidden props, one above the other, far from everything.
constexpr double kParkingSpacing = 100.0;  // m

// Tests that the absolute values of all numbers are below kLargestValue. Without their sign bits,
// doubles are ordered like the integers of the same bits, and NaN is above all numbers; a value
// that is too large makes the difference negative, which sets its top bit. The compiler vectorises
// this loop, but not one that compares doubles.
bool all_plausible(const double* values, int count) {
  constexpr std::uint64_t kSign = std::uint64_t{1} << 63;
  std::uint64_t differences = 0;
  for (int i = 0; i < count; ++i) {
    const std::uint64_t magnitude = std::bit_cast<std::uint64_t>(values[i]) & ~kSign;
    differences |= std::bit_cast<std::uint64_t>(kLargestValue) - 1 - magnitude;
  }
  return (differences & kSign) == 0;
}

}  // namespace

SceneWorkspace::SceneWorkspace(const PhysicsModel& model)
    : model_(&model), contact_workspace_(model.scenes()) {
  instances_.reserve(model.scenes().size());
  for (const SceneModel& scene : model.scenes()) {
    instances_.push_back({make_data_lazy_contacts(*scene.model), BroadPhase(*scene.model)});
    scene.kinematics.pose_fixed(*instances_.back().data);
  }
}

void SceneWorkspace::reset_data() {
  for (std::size_t i = 0; i < instances_.size(); ++i) {
    const SceneModel& scene = model_->scenes()[i];
    mj_resetData(scene.model.get(), instances_[i].data.get());
    scene.kinematics.pose_fixed(*instances_[i].data);
    instances_[i].owner = nullptr;
  }
}

bool SceneBinding::state_is_plausible() const {
  const int count = step_.num_props();
  return all_plausible(state_.qpos.row(env_), kRobotJoints) &&
         all_plausible(state_.qvel.row(env_), kRobotJoints) &&
         all_plausible(state_.prop_pos.row(env_), 3 * count) &&
         all_plausible(state_.prop_quat.row(env_), 4 * count) &&
         all_plausible(state_.prop_qvel.row(env_), 6 * count) &&
         all_plausible(state_.prop_qacc_warmstart.row(env_), 6 * count);
}

bool SceneBinding::is_plausible(const JointArray& qpos, const JointArray& qvel) const {
  bool good = all_plausible(qpos.data(), kRobotJoints) && all_plausible(qvel.data(), kRobotJoints);
  for (int prop = 0; prop < step_.num_props() && step_.num_awake > 0; ++prop) {
    if (!step_.is_awake(prop)) continue;
    const PropMotion& motion = workspace_.motion[at(prop)];
    good = good && all_plausible(motion.qpos.data(), 7) && all_plausible(motion.qvel.data(), 6);
  }
  return good;
}

// --- props that are awake or in motion ---

void SceneBinding::begin(bool sleep) {
  std::copy_n(state_.contact_force.row(env_), kRobotJoints, step_.contact_force.begin());
  std::fill(workspace_.awake_by_type.begin(), workspace_.awake_by_type.end(), 0);
  workspace_.moving.clear();
  for (int prop = 0; prop < step_.num_props(); ++prop) {
    const PropStatus status = state_.status_of(env_, prop);
    workspace_.status[at(prop)] = status;
    if (step_.prop_model(prop).free) {
      const bool present = status != PropStatus::kHidden;
      if (status == PropStatus::kAwake || (present && !sleep)) step_.wake(prop);
    } else if (status == PropStatus::kAwake) {
      begin_kinematic_motion(prop);
    }
  }
}

void SceneBinding::begin_kinematic_motion(int prop) {
  workspace_.moving.push_back(prop);
  workspace_.status[at(prop)] = PropStatus::kAsleep;
  std::copy_n(state_.prop_pos_of(env_, prop), 3, workspace_.motion[at(prop)].qpos.begin());
}

void SceneBinding::move_kinematic_props(int substep, int substeps) {
  const double part = static_cast<double>(substep) / substeps;
  const double per_second = 1 / (substeps * step_.model.robot_params().timestep);
  for (const int prop : step_.moving()) {
    PropMotion& motion = workspace_.motion[at(prop)];
    const double* from = state_.prop_pos_of(env_, prop);
    const double* displacement = step_.displacement_of(prop);
    for (std::size_t i = 0; i < 3; ++i) {
      motion.qpos[i] = from[i] + part * displacement[i];
      motion.qvel[i] = per_second * displacement[i];
    }
  }
}

std::span<const KinematicBody> SceneBinding::kinematic_bodies() {
  workspace_.kinematic_bodies.clear();
  for (const int prop : step_.moving()) {
    const int mocap = step_.scene->mocap[at(prop)];
    if (mocap < 0) continue;
    const Eigen::Map<const Eigen::Vector3d> velocity(workspace_.motion[at(prop)].qvel.data());
    workspace_.kinematic_bodies.push_back({mocap, velocity});
  }
  return workspace_.kinematic_bodies;
}

// --- from columns into the scene in use, and back ---

void SceneBinding::select_scene(int scene) {
  step_.scene_index = scene;
  step_.scene = &step_.model.scenes()[at(scene)];
  step_.instance = &scenes_.instance(scene);
  step_.instance->owner = nullptr;
  assign_slots();
}

void SceneBinding::load(const JointArray& qpos, const JointArray& qvel) {
  std::copy_n(qpos.begin(), kRobotJoints, step_.data().qpos);
  std::copy_n(qvel.begin(), kRobotJoints, step_.data().qvel);
  if (!step_.scene_has_props()) return;
  const bool is_mine = step_.instance->owner == &workspace_;
  if (!is_mine || !step_.moving().empty()) load_kinematic_props();
  if (!is_mine) load_free_props();
  step_.instance->owner = &workspace_;
}

void SceneBinding::load_kinematic_props() {
  for (int prop = 0; prop < step_.num_props(); ++prop) {
    const int mocap = step_.scene->mocap[at(prop)];
    if (mocap < 0) continue;
    const double parked[3] = {0, 0, -kParkingSpacing * (prop + 1)};
    const double* pos = step_.is_moving(prop) ? workspace_.motion[at(prop)].qpos.data()
                                              : state_.prop_pos_of(env_, prop);
    const bool hidden = workspace_.status[at(prop)] == PropStatus::kHidden;
    std::copy_n(hidden ? parked : pos, 3, step_.data().mocap_pos + 3 * mocap);
    std::copy_n(state_.prop_quat_of(env_, prop), 4, step_.data().mocap_quat + 4 * mocap);
  }
}

void SceneBinding::assign_slots() {
  workspace_.prop.clear();
  const int count = static_cast<int>(step_.scene->slots.size());
  for (int slot = 0; slot < count;) {
    const int type = step_.scene->slots[at(slot)].type;
    for (int prop = 0; prop < step_.num_props(); ++prop) {
      if (!step_.is_awake(prop) || step_.prop_model(prop).type != type) continue;
      workspace_.slot[at(prop)] = slot++;
      workspace_.prop.push_back(prop);
    }
    for (; slot < count && step_.scene->slots[at(slot)].type == type; ++slot) {
      workspace_.prop.push_back(EnvStep::kNoProp);
    }
  }
}

void SceneBinding::load_free_props() {
  for (int slot = 0; slot < static_cast<int>(workspace_.prop.size()); ++slot) {
    const int prop = workspace_.prop[at(slot)];
    if (prop != EnvStep::kNoProp) {
      load_slot(slot, workspace_.motion[at(prop)]);
    } else {
      load_slot(slot, {{0, 0, kParkingSpacing * (slot + 1), 1, 0, 0, 0}, {}, {}});
    }
  }
}

void SceneBinding::load_slot(int slot, const PropMotion& motion) const {
  const PropSlot& where = step_.scene->slots[at(slot)];
  std::copy_n(motion.qpos.begin(), 7, step_.data().qpos + where.qpos);
  std::copy_n(motion.qvel.begin(), 6, step_.data().qvel + where.dof);
  std::copy_n(motion.qacc_warmstart.begin(), 6, step_.data().qacc_warmstart + where.dof);
  std::fill_n(step_.data().qfrc_applied + where.dof, 6, 0.0);
}

void SceneBinding::read_back() {
  for (std::size_t slot = 0; slot < workspace_.prop.size(); ++slot) {
    const int prop = workspace_.prop[slot];
    if (prop == EnvStep::kNoProp) continue;
    const PropSlot& where = step_.scene->slots[slot];
    PropMotion& motion = workspace_.motion[at(prop)];
    std::copy_n(step_.data().qpos + where.qpos, 7, motion.qpos.begin());
    std::copy_n(step_.data().qvel + where.dof, 6, motion.qvel.begin());
    std::copy_n(step_.data().qacc_warmstart + where.dof, 6, motion.qacc_warmstart.begin());
  }
}

// --- into the columns ---

void SceneBinding::store(const JointArray& qpos, const JointArray& qvel) {
  std::copy_n(qpos.begin(), kRobotJoints, state_.qpos.row(env_));
  std::copy_n(qvel.begin(), kRobotJoints, state_.qvel.row(env_));
  std::copy_n(step_.contact_force.begin(), kRobotJoints, state_.contact_force.row(env_));
  if (step_.num_props() == 0) return;
  store_moving_props();
  std::fill_n(state_.finger_force.row(env_), 6 * step_.num_props(), 0.0);
  if (!step_.scene_has_props()) return;
  store_awake_props();
  store_finger_forces();
}

// Ends kinematic motion.
void SceneBinding::store_moving_props() const {
  for (const int prop : step_.moving()) {
    std::copy_n(workspace_.motion[at(prop)].qpos.begin(), 3, state_.prop_pos_of(env_, prop));
    std::fill_n(state_.prop_qvel_of(env_, prop), 6, 0.0);
    state_.prop_status.row(env_)[prop] = static_cast<std::uint8_t>(PropStatus::kAsleep);
  }
}

void SceneBinding::store_awake_props() const {
  for (int prop = 0; prop < step_.num_props(); ++prop) {
    if (!step_.is_awake(prop)) continue;
    const PropMotion& motion = workspace_.motion[at(prop)];
    std::copy_n(motion.qpos.begin(), 3, state_.prop_pos_of(env_, prop));
    std::copy_n(motion.qpos.begin() + 3, 4, state_.prop_quat_of(env_, prop));
    std::copy_n(motion.qvel.begin(), 6, state_.prop_qvel_of(env_, prop));
    std::copy_n(motion.qacc_warmstart.begin(), 6, state_.prop_qacc_warmstart.row(env_) + 6 * prop);
    state_.prop_status.row(env_)[prop] = static_cast<std::uint8_t>(PropStatus::kAwake);
  }
}

void SceneBinding::store_finger_forces() const {
  const mjModel& model = step_.scene_model();
  for (int i = 0; i < step_.data().ncon; ++i) {
    const mjContact& contact = step_.data().contact[i];
    if (contact.efc_address < 0) continue;
    const int bodies[2] = {model.geom_bodyid[contact.geom1], model.geom_bodyid[contact.geom2]};
    const int slot = std::max(step_.scene->slot_of_body[at(bodies[0])],
                              step_.scene->slot_of_body[at(bodies[1])]);
    const int prop = slot < 0 ? EnvStep::kNoProp : workspace_.prop[at(slot)];
    for (int finger = 0; finger < kFingers && prop >= 0; ++finger) {
      const int body = step_.model.finger_bodies()[finger];
      if (body != bodies[0] && body != bodies[1]) continue;
      mjtNum wrench[6];  // in the contact's frame, on the second body
      mj_contactForce(&model, &step_.data(), i, wrench);
      const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> frame(contact.frame);
      const Eigen::Vector3d force =
          frame.transpose() * Eigen::Vector3d(wrench[0], wrench[1], wrench[2]);
      Eigen::Map<Eigen::Vector3d> sum(state_.finger_force.row(env_) + 6 * prop + 3 * finger);
      sum += body == bodies[1] ? force : Eigen::Vector3d(-force);
    }
  }
}

}  // namespace engram
