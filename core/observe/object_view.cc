#include "core/observe/object_view.h"

#include <algorithm>
#include <numbers>

#include "core/base/index.h"

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
  const auto add = [this](const char* name, int width, double most, const char* unit,
                          const char* about) {
    ranged_fields_.push_back({{name, width, DType::kFloat32, unit, about}, -most, most, {}});
  };
  constexpr double kMax = ObjectTokens::kMax;
  add("qpos", kRobotJoints, kMax, "pi rad, 0.04 m", "arm joints, fingers");
  add("qvel", kRobotJoints, kMax, "pi rad/s, 0.04 m/s", "arm joints, fingers");
  add("tcp_pose", kPose, kMax, "0.5 m", "position, quaternion (w, x, y, z)");
  if (task_cue_dim_ > 0) {
    add("task_cue", task_cue_dim_, kMax, "pi rad", "of the cue that policies may see");
  }
  if (options_.time) {
    add("time", 1, 1, "", "elapsed steps, of the horizon's");
    ranged_fields_.back().low = 0;
  }
  const std::vector<RangedField> more = tokens_.fields();
  ranged_fields_.insert(ranged_fields_.end(), more.begin(), more.end());
  row_ = {"observation", 0, DType::kFloat32, "", "the objects observation"};
  for (const RangedField& part : ranged_fields_) {
    fields_.push_back(part.field);
    row_.width += part.field.width;
  }
  const auto size = at(options_.num_envs) * at(row_.width);
  rows_ = AlignedArray<float>(size);
  if (options_.keeps_final) final_rows_ = AlignedArray<float>(size);
}

void ObjectView::write(const State& state, int env, std::uint64_t key, const float* task_cue) {
  float* out = row(rows_, env);
  const auto append = [&out](const double* values, int count, double scale) {
    const double factor = 1 / scale;
    for (int i = 0; i < count; ++i) *out++ = ObjectTokens::cut_off(values[i] * factor);
  };
  for (const double* values : {state.qpos.row(env), state.qvel.row(env)}) {
    append(values, kArmJoints, kAngle);
    append(values + kArmJoints, kRobotJoints - kArmJoints, kFingerScale);
  }
  append(state.tcp_pos.row(env), 3, ObjectTokens::kPositionScale);
  append(state.tcp_quat.row(env), 4, 1);
  for (int i = 0; i < task_cue_dim_; ++i) {
    *out++ = ObjectTokens::cut_off(static_cast<double>(task_cue[i]) / kAngle);
  }
  if (options_.time) *out++ = std::min(1.0F, static_cast<float>(state.elapsed[env]) * per_step_);
  tokens_.write(state, env, key, out);
}

void ObjectView::keep_final(int env) {
  std::copy_n(row(rows_, env), row_.width, row(final_rows_, env));
}

}  // namespace engram
