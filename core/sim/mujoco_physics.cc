#include "core/sim/mujoco_physics.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/error.h"
#include "core/scene/free_body.h"
#include "core/scene/mujoco_versions.h"
#include "core/scene/physics_model.h"

namespace engram {
namespace {

// Height of hidden props, one above the other, m.
constexpr double kHiddenHeight = 100;

ModelPtr compile_scene(const SceneSpec& scene) {
  ModelPtr model = compile_model(scene.compose_all());
  std::fill_n(model->opt.gravity, 3, 0.0);
  return model;
}

bool all_below_limit(const mjtNum* values, std::int64_t count) {
  return std::all_of(values, values + count, [](mjtNum x) { return std::abs(x) < mjMAXVAL; });
}

// Copies numbers in single precision, as the original has them. MuJoCo solves for all bodies at
// once: what is hidden would show in the last bits of the others.
void copy_rounded(const mjtNum* from, int count, double* to) {
  constexpr double kNoise = 1e-12;  // m, rad, and per second: rounding of larger numbers
  std::transform(from, from + count, to,
                 [](mjtNum x) { return std::abs(x) < kNoise ? 0.0 : static_cast<float>(x); });
}

// Warnings that MuJoCo has counted: bad numbers, after which it resets the data without a word, and
// full buffers.
int count_warnings(const mjData& data) {
  int count = 0;
  for (const mjWarningStat& warning : data.warning) count += warning.number;
  return count;
}

// MuJoCo takes the gyroscopic torque of a substep's start. A slender prop in flight that spins at
// 80 rad/s gains energy by it without end. The torque given here is the difference to engram's own
// law (FreeBody::accelerate), which keeps the size of the angular momentum, and limits the spin.
void correct_spin(const mjModel& model, int prop, mjData& data) {
  const double h = model.opt.timestep;
  const FreeBody body(model, prop);
  const int joint = model.body_jntadr[prop];
  const mjtNum* const pos = data.qpos + model.jnt_qposadr[joint];
  FreeBodyState state = body.load(pos, pos + 3, data.qvel + model.jnt_dofadr[joint]);
  const Mat3 inv_inertia = body.inv_inertia(state.quat);
  const Mat3 inertia = inv_inertia.inverse();
  const Vec3 momentum = inertia * state.angular;
  const Vec3 turned = momentum - h * state.angular.cross(momentum);  // MuJoCo's
  const double size = turned.norm();
  if (size > 0) state.angular = inv_inertia * turned * (momentum.norm() / size);
  limit_spin(state);
  Eigen::Map<Vec3>{data.xfrc_applied + 6 * prop + 3} = (inertia * state.angular - turned) / h;
}

}  // namespace

MujocoPhysics::MujocoPhysics(const SceneSpec& scene, const PhysicsModel& model, int substeps,
                             int workers, int num_envs, ColumnStore& memory)
    : substeps_(substeps), drive_(model.robot_params().drive), mujoco_(compile_scene(scene)) {
  const mjModel& compiled = *mujoco_;
  prop_of_body_.assign(at(static_cast<int>(compiled.nbody)), -1);
  finger_of_body_.assign(at(static_cast<int>(compiled.nbody)), -1);
  finger_of_body_[at(mj_name2id(&compiled, mjOBJ_BODY, "leftfinger"))] = 0;
  finger_of_body_[at(mj_name2id(&compiled, mjOBJ_BODY, "rightfinger"))] = 1;
  for (const std::string& name : scene.props) {
    PropPlace place;
    place.body = mj_name2id(&compiled, mjOBJ_BODY, name.c_str());
    place.mocap = compiled.body_mocapid[place.body];
    if (place.mocap < 0) {
      const int joint = compiled.body_jntadr[place.body];
      place.qpos = compiled.jnt_qposadr[joint];
      place.dof = compiled.jnt_dofadr[joint];
      place.weight = model.gravity() * compiled.body_mass[place.body];
    }
    prop_of_body_[at(place.body)] = static_cast<int>(props_.size());
    props_.push_back(place);
  }
  workspaces_.reserve(at(workers));
  for (int worker = 0; worker < workers; ++worker) workspaces_.emplace_back(compiled);
  data_.reserve(at(num_envs));
  for (int env = 0; env < num_envs; ++env) {
    data_.push_back(make_data_lazy_contacts(compiled));
    release_stack(*data_.back());
  }
  warm_start_ =
      memory.add<double>("qacc_warmstart", static_cast<int>(compiled.nv), "rad/s^2, m/s^2");
}

void MujocoPhysics::step(const State& state, int first, int worker,
                         std::span<const DriveTarget> drives, bool* ok, StepClock::Worker* clock) {
  std::fill_n(ok, drives.size(), true);
  if (substeps_ == 0) return;
  const MujocoScope scope;
  for (std::size_t i = 0; i < drives.size(); ++i) {
    ok[i] = step_env(state, first + static_cast<int>(i), worker, drives[i]);
  }
  mark(clock, StepPart::kDynamics);
}

bool MujocoPhysics::step_env(const State& state, int env, int worker, const DriveTarget& drive) {
  mjData& data = *data_[at(env)];
  const WorkspaceLoan loan(data, workspaces_[at(worker)]);
  load(state, env, data);
  try {
    for (int substep = 0; substep < substeps_; ++substep) {
      move_kinematic_props(state, env, substep, data);
      apply_drive(drive, data);
      for (const PropPlace& prop : props_) {
        if (prop.mocap < 0) correct_spin(*mujoco_, prop.body, data);
      }
      mj_step1(mujoco_.get(), &data);
      pass_on_kinematic_velocities(state, env, data);
      mj_step2(mujoco_.get(), &data);
      if (count_warnings(data) > 0) return false;
    }
  } catch (const Error&) {
    return false;  // MuJoCo failed in the middle of a step; nothing has been stored
  }
  if (!all_below_limit(data.qpos, mujoco_->nq) || !all_below_limit(data.qvel, mujoco_->nv) ||
      !all_below_limit(data.qacc_warmstart, mujoco_->nv)) {
    return false;
  }
  store(state, env, data);
  return true;
}

std::size_t MujocoPhysics::bytes_per_env() const {
  std::size_t bytes = 0;
  for (const DataPtr& data : data_) bytes += resident_bytes(data);
  return bytes / data_.size();
}

const mjData& MujocoPhysics::current_data(const State& state, int env) {
  const MujocoScope scope;
  mjData& data = *data_[at(env)];
  load(state, env, data);
  mj_forward(mujoco_.get(), &data);
  return data;
}

// --- from the columns ---

void MujocoPhysics::load(const State& state, int env, mjData& data) const {
  clear_stack(data);
  std::fill(std::begin(data.warning), std::end(data.warning), mjWarningStat{});
  data.time = state.elapsed[env] * substeps_ * mujoco_->opt.timestep;
  std::copy_n(state.qpos.row(env), kRobotJoints, data.qpos);
  std::copy_n(state.qvel.row(env), kRobotJoints, data.qvel);
  std::copy_n(warm_start_.row(env), mujoco_->nv, data.qacc_warmstart);
  for (int prop = 0; prop < state.num_props; ++prop) load_prop(state, env, prop, data);
}

void MujocoPhysics::load_prop(const State& state, int env, int prop, mjData& data) const {
  const PropPlace& place = props_[at(prop)];
  const bool hidden = state.status_of(env, prop) == PropStatus::kHidden;
  const bool free = place.mocap < 0;
  mjtNum* const pos = free ? data.qpos + place.qpos : data.mocap_pos + 3 * place.mocap;
  mjtNum* const quat = free ? pos + 3 : data.mocap_quat + 4 * place.mocap;
  std::copy_n(state.prop_pos_of(env, prop), 3, pos);
  std::copy_n(state.prop_quat_of(env, prop), 4, quat);
  if (hidden) pos[2] = kHiddenHeight * (prop + 1);
  if (!free) return;
  std::copy_n(state.prop_qvel_of(env, prop), 6, data.qvel + place.dof);
  if (hidden) std::fill_n(data.qvel + place.dof, 6, 0.0);
  data.xfrc_applied[6 * place.body + 2] = hidden ? 0.0 : -place.weight;
}

// Kinematic props in motion are where they are at the beginning of the substep; after the last one
// at their goals.
void MujocoPhysics::move_kinematic_props(const State& state, int env, int substep,
                                         mjData& data) const {
  const double part = static_cast<double>(substep) / substeps_;
  for (int prop = 0; prop < state.num_props; ++prop) {
    const PropPlace& place = props_[at(prop)];
    if (!is_moving(state, env, prop)) continue;
    const double* from = state.prop_pos_of(env, prop);
    const double* displacement = state.prop_qvel_of(env, prop);
    for (int i = 0; i < 3; ++i) {
      data.mocap_pos[3 * place.mocap + i] = from[i] + part * displacement[i];
    }
  }
}

bool MujocoPhysics::is_moving(const State& state, int env, int prop) const {
  return props_[at(prop)].mocap >= 0 && state.status_of(env, prop) == PropStatus::kAwake;
}

// A mocap body has no velocity in MuJoCo. Where a contact has one in motion, its velocity is added
// to the contact's, and so to the acceleration that the contact aims at.
void MujocoPhysics::pass_on_kinematic_velocities(const State& state, int env, mjData& data) const {
  const double per_second = 1 / (substeps_ * mujoco_->opt.timestep);
  for (int i = 0; i < data.ncon; ++i) {
    const mjContact& contact = data.contact[i];
    if (contact.efc_address < 0) continue;
    for (const bool second : {false, true}) {
      const int prop =
          prop_of_body_[at(mujoco_->geom_bodyid[second ? contact.geom2 : contact.geom1])];
      if (prop < 0 || !is_moving(state, env, prop)) continue;
      const double* const displacement = state.prop_qvel_of(env, prop);
      for (int axis = 0; axis < std::min(3, contact.dim); ++axis) {
        const double along = mju_dot3(contact.frame + 3 * axis, displacement);
        const double speed = (second ? per_second : -per_second) * along;
        const int row = contact.efc_address + axis;
        data.efc_vel[row] += speed;
        data.efc_aref[row] -= data.efc_KBIP[4 * row + 1] * speed;
      }
    }
  }
}

// Targets are controls. A target velocity shifts them, as the damping would; in velocity mode so
// that no spring is left.
void MujocoPhysics::apply_drive(const DriveTarget& drive, mjData& data) const {
  for (std::size_t i = 0; i < kRobotJoints; ++i) {
    data.ctrl[i] = drive.qpos[i];
    if (i >= kArmJoints) continue;
    if (drive.velocity_mode) {
      const double damping = -mujoco_->actuator_biasprm[i * mjNBIAS + 2];
      data.ctrl[i] = data.qpos[i] + (damping - drive_.damping) / drive_.stiffness * data.qvel[i];
    }
    data.ctrl[i] += drive_.damping / drive_.stiffness * drive.qvel[i];
  }
}

// --- into the columns ---

void MujocoPhysics::store(const State& state, int env, const mjData& data) const {
  copy_rounded(data.qpos, kRobotJoints, state.qpos.row(env));
  copy_rounded(data.qvel, kRobotJoints, state.qvel.row(env));
  std::copy_n(data.qacc_warmstart, mujoco_->nv, warm_start_.row(env));
  for (int prop = 0; prop < state.num_props; ++prop) {
    const PropPlace& place = props_[at(prop)];
    std::uint8_t& status = state.prop_status.row(env)[prop];
    if (status == static_cast<std::uint8_t>(PropStatus::kHidden)) continue;
    if (place.mocap < 0) {
      copy_rounded(data.qpos + place.qpos, 3, state.prop_pos_of(env, prop));
      copy_rounded(data.qpos + place.qpos + 3, 4, state.prop_quat_of(env, prop));
      copy_rounded(data.qvel + place.dof, 6, state.prop_qvel_of(env, prop));
      status = static_cast<std::uint8_t>(PropStatus::kAwake);
    } else if (status == static_cast<std::uint8_t>(PropStatus::kAwake)) {
      double* const displacement = state.prop_qvel_of(env, prop);
      for (int i = 0; i < 3; ++i) state.prop_pos_of(env, prop)[i] += displacement[i];
      std::fill_n(displacement, 6, 0.0);
      status = static_cast<std::uint8_t>(PropStatus::kAsleep);
    }
  }
  store_finger_forces(state, env, data);
}

void MujocoPhysics::store_finger_forces(const State& state, int env, const mjData& data) const {
  std::fill_n(state.finger_force.row(env), state.finger_force.width(), 0.0);
  for (int i = 0; i < data.ncon; ++i) {
    const mjContact& contact = data.contact[i];
    const std::array<int, 2> bodies = {mujoco_->geom_bodyid[contact.geom1],
                                       mujoco_->geom_bodyid[contact.geom2]};
    for (std::size_t side = 0; side < 2; ++side) {
      const int finger = finger_of_body_[at(bodies[side])];
      const int prop = prop_of_body_[at(bodies[1 - side])];
      if (finger < 0 || prop < 0) continue;
      mjtNum force[6];
      mj_contactForce(mujoco_.get(), &data, i, force);
      const mjtNum* const axes = contact.frame;  // row by row, from the first geom to the second
      double* const sum = state.finger_force.row(env) + 6 * prop + 3 * finger;
      for (int k = 0; k < 3; ++k) {
        const double world = axes[k] * force[0] + axes[3 + k] * force[1] + axes[6 + k] * force[2];
        sum[k] += side == 1 ? world : -world;
      }
    }
  }
}

}  // namespace engram
