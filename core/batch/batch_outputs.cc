// Outputs of a batch: observations, rewards, images, and all of them by name.
#include <algorithm>
#include <numeric>

#include "core/base/error.h"
#include "core/base/join.h"
#include "core/batch/batch.h"

namespace engram {

void Batch::observe(Range envs) {
  for (int env = envs.begin; env < envs.end; ++env) observe_robot(env);
  if (!observes_state(options_.obs_mode)) return;
  if (rules_ == nullptr) {
    task_->observe(envs, task_rows());
    return;
  }
  work_.stepping.resize(static_cast<std::size_t>(envs.end - envs.begin));
  std::iota(work_.stepping.begin(), work_.stepping.end(), envs.begin);
  rules_->observe(work_.stepping, task_rows());
}

// All but the task's part.
void Batch::observe_robot(int env) {
  elapsed_steps_[env] = state_.elapsed[env];
  observe_proprio(env);
  if (objects_) observe_objects(env);
  if (!observes_state(options_.obs_mode)) return;
  float* out = observation_.row(env);
  const auto append = [&out](const double* values, int count) {
    out = std::transform(values, values + count, out,
                         [](double value) { return static_cast<float>(value); });
  };
  append(state_.qpos.row(env), kRobotJoints);
  append(state_.qvel.row(env), kRobotJoints);
  append(controller_->state_row(state_, env), controller_->state_dim());
  append(state_.tcp_pos.row(env), 3);
  append(state_.tcp_quat.row(env), 4);
}

FloatRows Batch::task_rows() {
  const int behind = 2 * kRobotJoints + controller_->state_dim() + 7;
  return {observation_.data() + behind, observation_.width()};
}

void Batch::observe_proprio(int env) {
  const double* qpos = state_.qpos.row(env);
  float* proprio = proprio_.row(env);
  const auto opening = static_cast<float>(qpos[kArmJoints] + qpos[kArmJoints + 1]);
  if (options_.joint_proprio) {
    for (int i = 0; i < kArmJoints; ++i) proprio[i] = static_cast<float>(qpos[i]);
    proprio[kArmJoints] = opening;
    return;
  }
  const double* pos = state_.tcp_pos.row(env);
  const double* quat = state_.tcp_quat.row(env);
  const Eigen::Vector3d angles =
      roll_pitch_yaw(Eigen::Quaterniond(quat[0], quat[1], quat[2], quat[3]));
  for (int i = 0; i < 3; ++i) {
    proprio[i] = static_cast<float>(pos[i]);
    proprio[3 + i] = static_cast<float>(angles[i]);
  }
  proprio[6] = opening;
}

void Batch::observe_objects(int env) {
  const float* cue = info().task_cue_dim > 0 ? bindings_.task_cue.row(env) : nullptr;
  objects_->write(state_, env, bindings_.stream_key(env), cue);
}

bool Batch::has_dense_reward() const {
  return options_.reward_mode == RewardMode::kDense ||
         options_.reward_mode == RewardMode::kNormalizedDense;
}

void Batch::compute_rewards(Range envs) {
  if (has_dense_reward()) task_->dense_reward(envs, {reward_.data(), 1});
  for (int env = envs.begin; env < envs.end; ++env) scale_reward(env);
}

// From the dense reward, where the mode has it.
void Batch::scale_reward(int env) {
  switch (options_.reward_mode) {
    case RewardMode::kNone:
      reward_[env] = 0;
      break;
    case RewardMode::kSparse:
      reward_[env] = bindings_.success[env] != 0 ? 1.0F : 0.0F;
      break;
    case RewardMode::kDense:
      break;
    case RewardMode::kNormalizedDense:
      reward_[env] /= static_cast<float>(task_->info().success_reward);
      break;
  }
}

template <class T>
std::span<const T> Batch::whole(const Column<T>& column) const {
  return {column.data(),
          static_cast<std::size_t>(num_envs()) * static_cast<std::size_t>(column.width())};
}

std::span<const float> Batch::observation() const {
  if (objects_) return objects_->all();
  if (!observes_state(options_.obs_mode)) return {};
  return whole(observation_);
}
std::span<const float> Batch::proprio() const { return whole(proprio_); }
std::span<const float> Batch::reward() const { return whole(reward_); }
std::span<const std::uint8_t> Batch::terminated() const { return whole(terminated_); }
std::span<const std::uint8_t> Batch::truncated() const { return whole(truncated_); }
std::span<const std::uint8_t> Batch::success() const { return whole(bindings_.success); }
std::span<const std::uint8_t> Batch::unstable() const { return whole(unstable_); }
std::span<const std::uint8_t> Batch::final_mask() const { return final_mask_.span(); }

ObservedImages Batch::images() const {
  if (!images_) return {};
  ObservedImages images = {
      images_->rgb().now(), images_->depth().now(), images_->segmentation().now(), {}};
  if (!images.segmentation.empty()) images.segmentation_names = images_->segments();
  return images;
}

ObservedImages Batch::final_images() const {
  if (!images_) return {};
  ObservedImages images = {
      images_->rgb().finals(), images_->depth().finals(), images_->segmentation().finals(), {}};
  if (!images.segmentation.empty()) images.segmentation_names = images_->segments();
  return images;
}

namespace {

ColumnView named(const ColumnStore& store, std::string_view name) {
  const ColumnView view = store.find(name);
  if (view.field != nullptr) return view;
  std::vector<std::string_view> names;
  names.reserve(store.size());
  for (std::size_t i = 0; i < store.size(); ++i) names.push_back(store[i].field->name);
  throw Error(Error::kUnknownId,
              "no output named '" + std::string(name) + "'; this task has: " + join(names));
}

}  // namespace

ColumnView Batch::output(std::string_view name) const {
  if (objects_ && name == kObservation) return objects_->rows();
  return named(outputs_, name);
}
ColumnView Batch::final_output(std::string_view name) const {
  if (objects_ && name == kObservation) return objects_->final_rows();
  return named(final_outputs_, name);
}

}  // namespace engram
