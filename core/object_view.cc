#include "core/object_view.h"

#include <algorithm>
#include <numbers>

namespace engram {
namespace {

constexpr int kPose = 7;               // TCP position and quaternion
constexpr double kFingerScale = 0.04;  // m, an open finger
constexpr double kAngle = std::numbers::pi;

}  // namespace

ObjectView::ObjectView(const TaskInfo& info, const ObjectTokens& tokens,
                       const ObjectViewOptions& options)
    : tokens_(tokens),
      options_(options),
      task_cue_dim_(info.task_cue_dim),
      per_step_(1.0F / static_cast<float>(info.horizon)) {
  fields_ = {{"qpos", kRobotJoints, DType::kFloat32, "pi rad, 0.04 m", "arm joints, fingers"},
             {"qvel", kRobotJoints, DType::kFloat32, "pi rad/s, 0.04 m/s", "arm joints, fingers"},
             {"tcp_pose", kPose, DType::kFloat32, "0.5 m", "position, quaternion (w, x, y, z)"}};
  if (task_cue_dim_ > 0) {
    fields_.push_back(
        {"task_cue", task_cue_dim_, DType::kFloat32, "pi rad", "of the cue that policies may see"});
  }
  if (options_.time) {
    fields_.push_back({"time", 1, DType::kFloat32, "", "elapsed steps, of the horizon's"});
  }
  const std::vector<Field> more = tokens_.fields();
  fields_.insert(fields_.end(), more.begin(), more.end());
  row_ = {"observation", 0, DType::kFloat32, "", "the objects observation"};
  for (const Field& field : fields_) row_.width += field.width;
  const auto size =
      static_cast<std::size_t>(options_.num_envs) * static_cast<std::size_t>(row_.width);
  rows_ = AlignedArray<float>(size);
  if (options_.keeps_final) final_rows_ = AlignedArray<float>(size);
}

void ObjectView::write(const State& state, int env, std::uint64_t key, const float* task_cue) {
  float* out = row(rows_, env);
  const auto append = [&out](const double* values, int count, double scale) {
    out = std::transform(values, values + count, out,
                         [scale](double value) { return static_cast<float>(value / scale); });
  };
  for (const double* values : {state.qpos.row(env), state.qvel.row(env)}) {
    append(values, kArmJoints, kAngle);
    append(values + kArmJoints, kRobotJoints - kArmJoints, kFingerScale);
  }
  append(state.tcp_pos.row(env), 3, ObjectTokens::kPositionScale);
  append(state.tcp_quat.row(env), 4, 1);
  for (int i = 0; i < task_cue_dim_; ++i) *out++ = task_cue[i] / static_cast<float>(kAngle);
  if (options_.time) *out++ = static_cast<float>(state.elapsed[env]) * per_step_;
  tokens_.write(state, env, key, out);
}

void ObjectView::keep_final(int env) {
  std::copy_n(row(rows_, env), row_.width, row(final_rows_, env));
}

}  // namespace engram
