#include "bench/mj_step_loop.h"

#include <algorithm>

#include "bench/interleave.h"

namespace engram::bench {

MjStepLoop::MjStepLoop(const Batch& batch)
    : batch_(batch),
      queries_(batch),
      model_(queries_.mujoco_model(0)),
      data_(make_data(model_)),
      noted_(static_cast<std::size_t>(batch.num_envs())) {
  for (Noted& noted : noted_) noted.warm_start.resize(static_cast<std::size_t>(model_.nv));
}

void MjStepLoop::note_states() {
  for (int env = 0; env < batch_.num_envs(); ++env) {
    const mjData& data = queries_.mujoco_data(env);
    Noted& noted = noted_[static_cast<std::size_t>(env)];
    noted.qpos.assign(data.qpos, data.qpos + model_.nq);
    noted.qvel.assign(data.qvel, data.qvel + model_.nv);
    noted.mocap_pos.assign(data.mocap_pos, data.mocap_pos + 3 * model_.nmocap);
    noted.mocap_quat.assign(data.mocap_quat, data.mocap_quat + 4 * model_.nmocap);
    noted.forces.assign(data.xfrc_applied, data.xfrc_applied + 6 * model_.nbody);
  }
}

void MjStepLoop::load(const Noted& noted) {
  std::copy(noted.qpos.begin(), noted.qpos.end(), data_->qpos);
  std::copy(noted.qvel.begin(), noted.qvel.end(), data_->qvel);
  std::copy(noted.mocap_pos.begin(), noted.mocap_pos.end(), data_->mocap_pos);
  std::copy(noted.mocap_quat.begin(), noted.mocap_quat.end(), data_->mocap_quat);
  std::copy(noted.forces.begin(), noted.forces.end(), data_->xfrc_applied);
  std::copy(noted.controls.begin(), noted.controls.end(), data_->ctrl);
  std::copy(noted.warm_start.begin(), noted.warm_start.end(), data_->qacc_warmstart);
}

double MjStepLoop::step_seconds() {
  for (int env = 0; env < batch_.num_envs(); ++env) {
    const mjtNum* const controls = queries_.mujoco_data(env).ctrl;
    noted_[static_cast<std::size_t>(env)].controls.assign(controls, controls + model_.nu);
  }
  const MujocoScope scope;
  double spent = 0;
  for (Noted& noted : noted_) {
    load(noted);
    spent += seconds([this] {
      for (int i = 0; i < batch_.options().substeps; ++i) mj_step(&model_, data_.get());
    });
    std::copy_n(data_->qacc_warmstart, model_.nv, noted.warm_start.begin());
  }
  return spent;
}

}  // namespace engram::bench
