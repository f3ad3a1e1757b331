// What a batch tells on demand: robot, cameras and what episodes have drawn.
#include <algorithm>

#include "core/base/error.h"
#include "core/base/ieee_scope.h"
#include "core/env/batch.h"

namespace engram {
namespace {

constexpr std::size_t kPose = 7;

void require_started(bool started, const char* what) {
  if (!started) {
    throw Error(Error::kBadState, std::string(what) + " before the first reset; reset first");
  }
}

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

void Batch::robot_state(std::span<float> qpos, std::span<float> qvel,
                        std::span<float> tcp_pose) const {
  require_started(started_, "robot state");
  constexpr auto kJoints = static_cast<std::size_t>(kRobotJoints);
  require_rows("qpos", qpos, num_envs(), kJoints);
  require_rows("qvel", qvel, num_envs(), kJoints);
  require_rows("tcp_pose", tcp_pose, num_envs(), kPose);
  for (int env = 0; env < num_envs(); ++env) {
    const auto index = static_cast<std::size_t>(env);
    copy_row(state_.qpos.row(env), kRobotJoints, qpos, index * kJoints);
    copy_row(state_.qvel.row(env), kRobotJoints, qvel, index * kJoints);
    copy_row(state_.tcp_pos.row(env), 3, tcp_pose, index * kPose);
    copy_row(state_.tcp_quat.row(env), 4, tcp_pose, index * kPose + 3);
  }
}

void Batch::camera_params(std::string_view camera, int width, int height, const CameraSpans& out) {
  const IeeeScope scope;
  require_started(started_, "camera parameters");
  check_image_size(width, height);
  require_rows("extrinsic_cv", out.extrinsic_cv, num_envs(), 12);
  require_rows("cam2world_gl", out.cam2world_gl, num_envs(), 16);
  require_rows("intrinsic_cv", out.intrinsic_cv, num_envs(), 9);
  if (!cameras_) cameras_ = std::make_unique<CameraPoses>(document(), *model_);
  const int index = cameras_->find(camera);
  const double focal = cameras_->focal_length(index, height);
  Eigen::Matrix3d intrinsic;
  intrinsic << focal, 0, width / 2.0, 0, focal, height / 2.0, 0, 0, 1;
  // From x right, y up, z backward to x right, y down, z forward.
  const Eigen::Vector3d flip(1, -1, -1);
  for (int env = 0; env < num_envs(); ++env) {
    const Eigen::Isometry3d pose = cameras_->pose(index, state_.qpos.row(env));
    Eigen::Matrix<double, 3, 4> extrinsic;
    extrinsic.leftCols<3>() = flip.asDiagonal() * pose.linear().transpose();
    extrinsic.col(3) = -(extrinsic.leftCols<3>() * pose.translation());
    write(extrinsic, out.extrinsic_cv, env);
    write(pose.matrix(), out.cam2world_gl, env);
    write(intrinsic, out.intrinsic_cv, env);
  }
}

int Batch::drawn_dim() const {
  int dim = 0;
  for (const Field& field : info().drawn) dim += field.width;
  return dim;
}

void Batch::drawn(std::span<float> values) const {
  require_started(started_, "drawn values");
  const auto dim = static_cast<std::size_t>(drawn_dim());
  require_length("drawn values", values.size(), static_cast<std::size_t>(num_envs()) * dim);
  if (dim == 0) return;
  for (int env = 0; env < num_envs(); ++env) {
    task_->drawn(env, values.data() + static_cast<std::size_t>(env) * dim);
  }
}

}  // namespace engram
