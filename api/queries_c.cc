// Queries of a batch, in C.
#include <span>

#include "api/c_batch.h"
#include "api/c_text.h"
#include "engram/engram_c.h"
#include "protocol/io/json.h"
// begin generated: includes (tools/surface, from api/surface.toml)
#include "protocol/eval/policies/episode_question.h"
#include "protocol/make/episode_words.h"
// end generated

using engram::c::refuse_null;
using engram::c::with_env;

namespace {

// Copies the JSON text of what `describe` says of an environment.
template <class Describe>
engram_status text_query(engram_env* env, int32_t index, char* text, size_t capacity,
                         size_t* length, Describe&& describe) {
  if (text == nullptr && capacity > 0) return refuse_null("text");
  return with_env(env, [&](engram_env& of) {
    const auto [part, own_index] = of.batch->locate(index);
    engram::c::give_text(engram::to_text(describe(of.batch->part(part), own_index)), text, capacity,
                         length);
  });
}

// A caller's array of `width` floats for each environment; empty if there is none.
std::span<float> rows(const engram_env& env, float* values, size_t width) {
  if (values == nullptr) return {};
  return {values, static_cast<size_t>(env.batch->num_envs()) * width};
}

}  // namespace

// begin generated: definitions
engram_status engram_words(engram_env* env, int32_t index, char* text, size_t capacity,
                           size_t* length) {
  return text_query(env, index, text, capacity, length, engram::describe_words);
}

engram_status engram_question(engram_env* env, int32_t index, char* text, size_t capacity,
                              size_t* length) {
  return text_query(env, index, text, capacity, length, engram::describe_question);
}

engram_status engram_robot_state(engram_env* env, float* qpos, float* qvel, float* tcp_pose) {
  return with_env(env, [&](engram_env& of) {
    of.queries.robot_state(rows(of, qpos, 9), rows(of, qvel, 9), rows(of, tcp_pose, 7));
  });
}

engram_status engram_camera_params(engram_env* env, const char* camera, int32_t width,
                                   int32_t height, float* extrinsic_cv, float* cam2world_gl,
                                   float* intrinsic_cv) {
  if (camera == nullptr) return refuse_null("camera");
  return with_env(env, [&](engram_env& of) {
    of.queries.camera_params(camera, width, height,
                             {.extrinsic_cv = rows(of, extrinsic_cv, 12),
                              .cam2world_gl = rows(of, cam2world_gl, 16),
                              .intrinsic_cv = rows(of, intrinsic_cv, 9)});
  });
}
// end generated

engram_status engram_mujoco_model(engram_env* env, int32_t index, const mjModel_** model) {
  if (model == nullptr) return refuse_null("model");
  *model = nullptr;
  return with_env(env, [&](engram_env& of) { *model = &of.queries.mujoco_model(index); });
}

engram_status engram_mujoco_data(engram_env* env, int32_t index, const mjData_** data) {
  if (data == nullptr) return refuse_null("data");
  *data = nullptr;
  return with_env(env, [&](engram_env& of) { *data = &of.queries.mujoco_data(index); });
}

const char* engram_mujoco_version(void) { return mj_versionString(); }
