// Observations: proprioception, states, objects and images.
#include <algorithm>
#include <numeric>

#include "core/batch/batch_data.h"

namespace engram {

void BatchData::observe(Range envs) {
  for (int env = envs.begin; env < envs.end; ++env) observe_robot(env);
  if (!observes_state(options.obs_mode)) return;
  if (batch_task == nullptr) {
    task->observe(envs, task_rows());
    return;
  }
  list.resize(at(envs.end - envs.begin));
  std::iota(list.begin(), list.end(), envs.begin);
  batch_task->observe(list, task_rows());
}

// All but the task's part.
void BatchData::observe_robot(int env) {
  elapsed_steps[env] = state.elapsed[env];
  observe_proprio(env);
  if (objects) {
    const float* cue = info().task_cue_dim > 0 ? bindings.task_cue.row(env) : nullptr;
    objects->write(state, env, bindings.stream_key(env), cue);
  }
  if (!observes_state(options.obs_mode)) return;
  float* out = observation.row(env);
  const auto append = [&out](const double* values, int count) {
    out = std::transform(values, values + count, out,
                         [](double value) { return static_cast<float>(value); });
  };
  append(state.qpos.row(env), kRobotJoints);
  append(state.qvel.row(env), kRobotJoints);
  append(controller->state_row(state, env), controller->state_dim());
  append(state.tcp_pos.row(env), 3);
  append(state.tcp_quat.row(env), 4);
}

FloatRows BatchData::task_rows() {
  const int behind = 2 * kRobotJoints + controller->state_dim() + 7;
  return {observation.data() + behind, observation.width()};
}

void BatchData::observe_proprio(int env) {
  const double* qpos = state.qpos.row(env);
  float* out = proprio.row(env);
  const auto opening = static_cast<float>(qpos[kArmJoints] + qpos[kArmJoints + 1]);
  if (options.joint_proprio) {
    for (int i = 0; i < kArmJoints; ++i) out[i] = static_cast<float>(qpos[i]);
    out[kArmJoints] = opening;
    return;
  }
  const double* pos = state.tcp_pos.row(env);
  const double* quat = state.tcp_quat.row(env);
  const Eigen::Vector3d angles =
      roll_pitch_yaw(Eigen::Quaterniond(quat[0], quat[1], quat[2], quat[3]));
  for (int i = 0; i < 3; ++i) {
    out[i] = static_cast<float>(pos[i]);
    out[3 + i] = static_cast<float>(angles[i]);
  }
  out[6] = opening;
}

std::uint64_t BatchData::image_noise_key(int env) const {
  constexpr std::uint64_t kNextStep = 0xd1b54a32d192ed03u;
  const auto elapsed = static_cast<std::uint64_t>(state.elapsed[env]);
  return noise_stream(env, kPurposeImageNoise).next_u64() + elapsed * kNextStep;
}

void BatchData::render(int worker, int env) {
  if (!images) return;
  if (perturbations.change_images()) {
    const ImageChanges changes = perturbations.images(env);
    images->render(worker, state, env, &changes, image_noise_key(env));
  } else {
    images->render(worker, state, env);
  }
  mark(clock(worker), StepPart::kRender);
}

}  // namespace engram
