#include "core/batch/queries.h"

#include <algorithm>

#include "core/base/error.h"
#include "core/base/ieee_scope.h"

namespace engram {
namespace {

constexpr std::size_t kPose = 7;

// Empty, or one row of `width` floats for each environment.
void require_rows(const char* what, std::span<const float> out, int rows, std::size_t width) {
  if (!out.empty()) require_length(what, out.size(), static_cast<std::size_t>(rows) * width);
}

void copy_row(const double* values, int count, std::span<float> out, std::size_t at) {
  if (out.empty()) return;
  std::transform(values, values + count, out.begin() + static_cast<std::ptrdiff_t>(at),
                 [](double value) { return static_cast<float>(value); });
}

// A matrix, row by row.
template <class Matrix>
void write(const Matrix& matrix, std::span<float> out, int env) {
  if (out.empty()) return;
  float* next = out.data() + static_cast<std::ptrdiff_t>(env) * matrix.size();
  for (Eigen::Index row = 0; row < matrix.rows(); ++row) {
    for (Eigen::Index column = 0; column < matrix.cols(); ++column) {
      *next++ = static_cast<float>(matrix(row, column));
    }
  }
}

}  // namespace

void Queries::robot_state(std::span<float> qpos, std::span<float> qvel,
                          std::span<float> tcp_pose) const {
  batch_.require_started("robot state");
  constexpr auto kJoints = static_cast<std::size_t>(kRobotJoints);
  const int num_envs = batch_.num_envs();
  require_rows("qpos", qpos, num_envs, kJoints);
  require_rows("qvel", qvel, num_envs, kJoints);
  require_rows("tcp_pose", tcp_pose, num_envs, kPose);
  const State& state = batch_.state();
  for (int env = 0; env < num_envs; ++env) {
    const auto index = static_cast<std::size_t>(env);
    copy_row(state.qpos.row(env), kRobotJoints, qpos, index * kJoints);
    copy_row(state.qvel.row(env), kRobotJoints, qvel, index * kJoints);
    copy_row(state.tcp_pos.row(env), 3, tcp_pose, index * kPose);
    copy_row(state.tcp_quat.row(env), 4, tcp_pose, index * kPose + 3);
  }
}

void Queries::camera_params(std::string_view camera, int width, int height,
                            const CameraSpans& out) {
  const IeeeScope scope;
  batch_.require_started("camera parameters");
  check_image_size(width, height);
  const int num_envs = batch_.num_envs();
  require_rows("extrinsic_cv", out.extrinsic_cv, num_envs, 12);
  require_rows("cam2world_gl", out.cam2world_gl, num_envs, 16);
  require_rows("intrinsic_cv", out.intrinsic_cv, num_envs, 9);
  if (!cameras_) {
    cameras_ = std::make_unique<CameraPoses>(document(), batch_.physics_model());
  }
  const int index = cameras_->find(camera);
  // Change of axes: x right, y up, z backward to x right, y down, z forward.
  const Eigen::Vector3d flip(1, -1, -1);
  for (int env = 0; env < num_envs; ++env) {
    const ImageChanges changes = batch_.perturbations_.images(env);
    const Eigen::Isometry3d pose = cameras_->pose(index, batch_.state().qpos.row(env), changes);
    const double focal = cameras_->focal_length(index, height, changes);
    Eigen::Matrix3d intrinsic;
    intrinsic << focal, 0, width / 2.0, 0, focal, height / 2.0, 0, 0, 1;
    Eigen::Matrix<double, 3, 4> extrinsic;
    extrinsic.leftCols<3>() = flip.asDiagonal() * pose.linear().transpose();
    extrinsic.col(3) = -(extrinsic.leftCols<3>() * pose.translation());
    write(extrinsic, out.extrinsic_cv, env);
    write(pose.matrix(), out.cam2world_gl, env);
    write(intrinsic, out.intrinsic_cv, env);
  }
}

int Queries::sampled_dim() const {
  int dim = 0;
  for (const Field& field : batch_.info().sampled_values) dim += field.width;
  return dim;
}

void Queries::sampled_values(std::span<float> values) const {
  batch_.require_started("drawn values");
  const auto dim = static_cast<std::size_t>(sampled_dim());
  const int num_envs = batch_.num_envs();
  require_length("drawn values", values.size(), static_cast<std::size_t>(num_envs) * dim);
  if (dim == 0) return;
  for (int env = 0; env < num_envs; ++env) {
    batch_.task_->sampled_values(env, values.data() + static_cast<std::size_t>(env) * dim);
  }
}

std::string Queries::instruction(int env) const {
  const IeeeScope scope;
  batch_.check_env(env);
  if (!batch_.perturbations_.has(PerturbationAxis::kInstruction)) {
    return batch_.task_->instruction(env);
  }
  std::vector<std::string> all = wordings(env);
  return all[static_cast<std::size_t>(
      batch_.perturbations_.wording(env, static_cast<int>(all.size())))];
}

// The task's own instruction, then others.
std::vector<std::string> Queries::wordings(int env) const {
  std::vector<std::string> all = {batch_.task_->instruction(env)};
  std::ranges::move(batch_.task_->paraphrases(all.front()), std::back_inserter(all));
  return all;
}

std::vector<std::string> Queries::paraphrases() const {
  return batch_.task_->paraphrases(batch_.info().instruction);
}

std::vector<std::string> Queries::paraphrases(int env) const {
  const std::string used = instruction(env);
  const IeeeScope scope;
  std::vector<std::string> others = wordings(env);
  std::erase(others, used);
  return others;
}

int Queries::cue_end(int env) const {
  const IeeeScope scope;
  batch_.check_env(env);
  return batch_.task_->cue_end(env);
}

const AnswerController* Queries::choices() const { return answer_controller_of(*batch_.task_); }

const AnswerController& Queries::running_answer_controller() const {
  batch_.require_started("choices");
  const AnswerController* own = choices();
  if (own == nullptr) {
    throw Error(Error::kInvalidArgument,
                batch_.info().id + " has no list of answers to choose from");
  }
  return *own;
}

const Annotator* Queries::annotator() const {
  batch_.require_started("words of an episode");
  return batch_.task_->annotator();
}

std::span<const RangedField> Queries::ranged_fields() const {
  if (!batch_.objects_) return {};
  return batch_.objects_->ranged_fields();
}

std::string Queries::document() const {
  const IeeeScope scope;
  return batch_.task_->document();
}

std::size_t Queries::bytes_per_env() const {
  const Batch& batch = batch_;
  const std::size_t images = batch.images_ ? batch.images_->bytes() : 0;
  const std::size_t objects = batch.objects_ ? batch.objects_->bytes() : 0;
  return images + objects + batch.memory_.row_bytes() + batch.pin_memory_.row_bytes() +
         2 * batch.outputs_.row_bytes();
}

}  // namespace engram
