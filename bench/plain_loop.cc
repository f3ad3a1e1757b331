#include "bench/plain_loop.h"

#include <algorithm>

namespace engram::bench {
namespace {

// Drives in the usual form of MuJoCo models: explicit springs, the damping in the inertia, and a
// kilogram for the fingers, which makes them stable at this time step. Limits are constraints.
ModelPtr with_explicit_drives(const mjModel& engine_model, const RobotParams& params) {
  ModelPtr model(mj_copyModel(nullptr, &engine_model));
  for (int i = 0; i < kRobotJoints; ++i) {
    const double rotor = i < kArmJoints ? 0.005 : 1.0;
    model->dof_armature[i] = rotor + params.timestep * params.drive.damping;
    model->jnt_limited[i] = 1;
    model->actuator_gainprm[i * mjNGAIN] = 1;
    model->actuator_biastype[i] = mjBIAS_NONE;
    model->actuator_forcelimited[i] = 0;
  }
  std::fill_n(model->tendon_stiffness, model->ntendon, 2000.0);
  return model;
}

void apply_drive(const DriveParams& params, const DriveTarget& drive, mjData& data) {
  for (std::size_t i = 0; i < kRobotJoints; ++i) {
    const double force =
        params.stiffness * (drive.qpos[i] - data.qpos[i]) - params.damping * data.qvel[i];
    data.ctrl[i] = std::clamp(force, -params.limit, params.limit);
  }
}

}  // namespace

PlainLoop::PlainLoop(const Batch& reference, SceneKind kind)
    : reference_(reference),
      model_(with_explicit_drives(kind == SceneKind::kFull ? reference.physics_model().full()
                                                           : reference.physics_model().robot(),
                                  reference.physics_model().robot_params())),
      full_(kind == SceneKind::kFull),
      controller_(*reference.options().control_mode, reference.physics_model().arm(),
                  reference.physics_model().joint_ranges(), reference.options().rotation_sign),
      store_(reference.num_envs()),
      state_(store_, reference.state().num_props) {
  for (int env = 0; env < reference.num_envs(); ++env) data_.push_back(make_data(*model_));
  shown_.assign(static_cast<std::size_t>(reference.num_envs() * reference.state().num_props), 2);
  for (int env = 0; env < reference.num_envs(); ++env) load_robot(env);
  sync_scene();
}

void PlainLoop::load_robot(int env) {
  mjData* data = data_[static_cast<std::size_t>(env)].get();
  std::copy_n(reference_.state().qpos.row(env), kRobotJoints, data->qpos);
  std::copy_n(reference_.state().qvel.row(env), kRobotJoints, data->qvel);
}

// Hidden props wait, weightless, far from everything.
void PlainLoop::load_prop(int env, int prop) {
  const PhysicsModel& physics = reference_.physics_model();
  const PropModel& about = physics.props()[static_cast<std::size_t>(prop)];
  const int body = mj_name2id(model_.get(), mjOBJ_BODY, about.name.c_str());
  mjData* data = data_[static_cast<std::size_t>(env)].get();
  const bool present = reference_.state().status_of(env, prop) != PropStatus::kHidden;
  const double* pos = reference_.state().prop_pos_of(env, prop);
  const double hidden[3] = {0, 0, 100.0 * (prop + 1)};
  if (!about.free) {
    std::copy_n(present ? pos : hidden, 3, data->mocap_pos + 3 * model_->body_mocapid[body]);
    return;
  }
  const int dof = model_->body_dofadr[body];
  mjtNum* const qpos = data->qpos + model_->jnt_qposadr[model_->body_jntadr[body]];
  std::copy_n(present ? pos : hidden, 3, qpos);
  std::copy_n(reference_.state().prop_quat_of(env, prop), 4, qpos + 3);
  std::fill_n(data->qvel + dof, 6, 0.0);
  data->qfrc_applied[dof + 2] = present ? -about.mass * physics.gravity() : 0.0;
}

void PlainLoop::sync_scene() {
  const int props = reference_.state().num_props;
  for (int env = 0; env < reference_.num_envs(); ++env) {
    const bool new_episode = reference_.state().elapsed[env] == 0;
    if (new_episode) load_robot(env);
    if (!full_) continue;
    for (int prop = 0; prop < props; ++prop) {
      std::uint8_t& shown = shown_[static_cast<std::size_t>(env * props + prop)];
      const std::uint8_t now =
          reference_.state().status_of(env, prop) == PropStatus::kHidden ? 0 : 1;
      if (now != shown || new_episode) load_prop(env, prop);
      shown = now;
    }
  }
}

void PlainLoop::step(std::span<const float> actions) {
  const MujocoScope scope;
  const DriveParams& params = reference_.physics_model().robot_params().drive;
  const int dim = controller_.action_space().dim();
  for (int env = 0; env < reference_.num_envs(); ++env) {
    mjData* data = data_[static_cast<std::size_t>(env)].get();
    std::copy_n(data->qpos, kRobotJoints, state_.qpos.row(env));
    const DriveTarget drive = controller_.drive(state_, env, actions.data() + env * dim);
    for (int substep = 0; substep < reference_.options().substeps; ++substep) {
      apply_drive(params, drive, *data);
      mj_step(model_.get(), data);
    }
  }
}

}  // namespace engram::bench
