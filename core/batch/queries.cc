#include "core/batch/queries.h"

#include <algorithm>

#include "core/base/error.h"
#include "core/base/ieee_scope.h"
#include "core/batch/resting_scene.h"

namespace engram {
namespace {

constexpr std::size_t kPose = 7;

// Empty, or one row of `width` floats for each environment.
void require_rows(const char* what, std::span<const float> out, int rows, std::size_t width) {
  if (!out.empty()) require_length(what, out.size(), at(rows) * width);
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

Queries::Queries(const Batch& batch) : batch_(batch), cameras_(at(batch.num_parts())) {}

BatchData& Queries::data() const { return BatchAccess::data(batch_); }

BatchData& Queries::data(int part) const { return BatchAccess::data(batch_.part(part)); }

void Queries::require_started(const char* what) const {
  for (int i = 0; i < batch_.num_parts(); ++i) data(i).require_started(what);
}

std::pair<BatchData&, int> Queries::locate_mujoco(int index) const {
  const auto [part, env] = batch_.locate(index);
  BatchData& of_part = data(part);
  if (of_part.mujoco == nullptr) {
    throw Error(Error::kInvalidArgument,
                "MuJoCo's model and data: a batch with physics 'engram' "
                "given, one with physics 'mujoco' needed");
  }
  return {of_part, env};
}

const mjModel& Queries::mujoco_model(int env) const {
  return locate_mujoco(env).first.mujoco->model();
}

const mjData& Queries::mujoco_data(int index) const {
  const IeeeScope scope;
  const auto [of_part, env] = locate_mujoco(index);
  of_part.require_started("MuJoCo's data");
  return of_part.mujoco->current_data(of_part.state, env);
}

std::uint64_t Queries::unstable_count() const {
  std::uint64_t count = 0;
  for (int i = 0; i < batch_.num_parts(); ++i) count += data(i).unstable_count.load();
  return count;
}

void Queries::robot_state(std::span<float> qpos, std::span<float> qvel,
                          std::span<float> tcp_pose) const {
  require_started("robot state");
  constexpr auto kJoints = at(kRobotJoints);
  const int num_envs = batch_.num_envs();
  require_rows("qpos", qpos, num_envs, kJoints);
  require_rows("qvel", qvel, num_envs, kJoints);
  require_rows("tcp_pose", tcp_pose, num_envs, kPose);
  for (int index = 0; index < num_envs; ++index) {
    const auto [part, env] = batch_.locate(index);
    const State& state = data(part).state;
    copy_row(state.qpos.row(env), kRobotJoints, qpos, at(index) * kJoints);
    copy_row(state.qvel.row(env), kRobotJoints, qvel, at(index) * kJoints);
    copy_row(state.tcp_pos.row(env), 3, tcp_pose, at(index) * kPose);
    copy_row(state.tcp_quat.row(env), 4, tcp_pose, at(index) * kPose + 3);
  }
}

void Queries::camera_params(std::string_view camera, int width, int height,
                            const CameraSpans& out) {
  const IeeeScope scope;
  require_started("camera parameters");
  check_image_size(width, height);
  const int num_envs = batch_.num_envs();
  require_rows("extrinsic_cv", out.extrinsic_cv, num_envs, 12);
  require_rows("cam2world_gl", out.cam2world_gl, num_envs, 16);
  require_rows("intrinsic_cv", out.intrinsic_cv, num_envs, 9);
  // Change of axes: x right, y up, z backward to x right, y down, z forward.
  const Eigen::Vector3d flip(1, -1, -1);
  for (int index = 0; index < num_envs; ++index) {
    const auto [part, env] = batch_.locate(index);
    const BatchData& of = data(part);
    std::unique_ptr<CameraPoses>& cameras = cameras_[at(part)];
    if (!cameras) cameras = std::make_unique<CameraPoses>(of.task->document(), *of.model);
    const int number = cameras->find(camera);
    const ImageChanges changes = of.perturbations.images(env);
    const Eigen::Isometry3d pose = cameras->pose(number, of.state.qpos.row(env), changes);
    const double focal = cameras->focal_length(number, height, changes);
    Eigen::Matrix3d intrinsic;
    intrinsic << focal, 0, width / 2.0, 0, focal, height / 2.0, 0, 0, 1;
    Eigen::Matrix<double, 3, 4> extrinsic;
    extrinsic.leftCols<3>() = flip.asDiagonal() * pose.linear().transpose();
    extrinsic.col(3) = -(extrinsic.leftCols<3>() * pose.translation());
    write(extrinsic, out.extrinsic_cv, index);
    write(pose.matrix(), out.cam2world_gl, index);
    write(intrinsic, out.intrinsic_cv, index);
  }
}

int Queries::sampled_dim() const {
  if (batch_.is_common()) return 0;
  int dim = 0;
  for (const Field& field : batch_.info().sampled_values) dim += field.width;
  return dim;
}

void Queries::sampled_values(std::span<float> values) const {
  if (!batch_.is_common()) require_started("drawn values");
  const std::size_t dim = at(sampled_dim());
  require_length("drawn values", values.size(), at(batch_.num_envs()) * dim);
  if (dim == 0) return;
  for (int env = 0; env < batch_.num_envs(); ++env) {
    data().task->sampled_values(env, values.data() + at(env) * dim);
  }
}

std::string Queries::instruction(int env) const {
  const IeeeScope scope;
  const auto [part, own] = batch_.locate(env);
  const BatchData& of = data(part);
  if (!of.perturbations.has(PerturbationAxis::kInstruction)) return of.task->instruction(own);
  std::vector<std::string> all = wordings(of, own);
  return all[at(of.perturbations.wording(own, static_cast<int>(all.size())))];
}

// The task's own instruction, then others.
std::vector<std::string> Queries::wordings(const BatchData& data, int env) {
  std::vector<std::string> all = {data.task->instruction(env)};
  std::ranges::move(data.task->paraphrases(all.front()), std::back_inserter(all));
  return all;
}

std::vector<std::string> Queries::paraphrases() const {
  return data().task->paraphrases(batch_.info().instruction);
}

std::vector<std::string> Queries::paraphrases(int env) const {
  const std::string used = instruction(env);
  const IeeeScope scope;
  const auto [part, own] = batch_.locate(env);
  std::vector<std::string> others = wordings(data(part), own);
  std::erase(others, used);
  return others;
}

int Queries::cue_end(int env) const {
  const IeeeScope scope;
  const auto [part, own] = batch_.locate(env);
  return data(part).task->cue_end(own);
}

const AnswerController* Queries::choices() const { return answer_controller_of(*data().task); }

const AnswerController& Queries::running_answer_controller() const {
  data().require_started("choices");
  const AnswerController* own = choices();
  if (own == nullptr) {
    throw Error(Error::kInvalidArgument,
                batch_.info().id + " has no list of answers to choose from");
  }
  return *own;
}

const Annotator* Queries::annotator() const {
  data().require_started("words of an episode");
  return data().task->annotator();
}

std::span<const RangedField> Queries::ranged_fields() const {
  if (!data().objects) return {};
  return data().objects->ranged_fields();
}

std::string Queries::document() const {
  const IeeeScope scope;
  return data().task->document();
}

std::string Queries::drawn_document(int env) const {
  const IeeeScope scope;
  require_started("drawn scene");
  const auto [part, own] = batch_.locate(env);
  const State& state = data(part).state;
  DrawnScene drawn;
  std::copy_n(state.qpos.row(own), kRobotJoints, drawn.qpos.begin());
  for (int i = 0; i < state.num_props; ++i) {
    DrawnProp& prop = drawn.props.emplace_back();
    std::copy_n(state.prop_pos_of(own, i), 3, prop.pos.begin());
    std::copy_n(state.prop_quat_of(own, i), 4, prop.quat.begin());
    std::copy_n(state.prop_rgba.row(own) + 4 * i, 4, prop.rgba.begin());
    prop.hidden = state.status_of(own, i) == PropStatus::kHidden;
  }
  const Task& task = *data(part).task;
  return task.drawn_document(resting_scene(task, *data(part).model, drawn));
}

std::size_t Queries::bytes_per_env() const {
  const BatchData& of = data();
  const std::size_t images = of.images ? of.images->bytes() : 0;
  const std::size_t objects = of.objects ? of.objects->bytes() : 0;
  const std::size_t mujoco = of.mujoco ? of.mujoco->bytes_per_env() : 0;
  return images + objects + mujoco + of.memory.row_bytes() + of.pin_memory.row_bytes() +
         2 * of.outputs.row_bytes();
}

}  // namespace engram
