#include "api/c_batch.h"

#include <algorithm>

namespace engram::c {
namespace {

std::int32_t dtype_of(DType type) {
  switch (type) {
    case DType::kBool:
      return ENGRAM_BOOL;
    case DType::kInt32:
      return ENGRAM_INT32;
    case DType::kUInt64:
      return ENGRAM_UINT64;
    case DType::kFloat32:
      return ENGRAM_FLOAT32;
    case DType::kFloat64:
      return ENGRAM_FLOAT64;
  }
  return ENGRAM_UINT8;
}

engram_array column_array(const ColumnView& column, int num_envs) {
  const Field& field = *column.field;
  engram_array array{};
  array.name = field.name.c_str();
  array.unit = field.unit.c_str();
  array.description = field.description.c_str();
  array.data = column.data;
  array.dtype = dtype_of(field.dtype);
  array.ndim = field.width == 1 ? 1 : 2;
  array.shape[0] = num_envs;
  array.shape[1] = field.width == 1 ? 0 : field.width;
  return array;
}

// Values of each pixel, cameras one behind the other.
engram_array image_array(const Batch& env, const void* data, std::int32_t dtype, int channels) {
  const ImageShape& shape = env.options().images;
  engram_array array{};
  array.unit = "";
  array.data = data;
  array.dtype = dtype;
  array.ndim = 4;
  array.shape[0] = env.num_envs();
  array.shape[1] = shape.height;
  array.shape[2] = shape.width;
  array.shape[3] = channels * static_cast<std::int64_t>(shape.cameras.size());
  return array;
}

void add_images(const Batch& env, const ObservedImages& images, std::vector<engram_array>& arrays) {
  if (!images.rgb.empty()) {
    arrays.push_back(image_array(env, images.rgb.data(), ENGRAM_UINT8, 3));
    arrays.back().name = "rgb";
    arrays.back().description = "images, row 0 on top, cameras one behind the other in each pixel";
  }
  if (!images.depth.empty()) {
    arrays.push_back(image_array(env, images.depth.data(), ENGRAM_INT16, 1));
    arrays.back().name = "depth";
    arrays.back().unit = "mm";
    arrays.back().description = "along the axis of each camera; 0: nothing there";
  }
  if (!images.segmentation.empty()) {
    arrays.push_back(image_array(env, images.segmentation.data(), ENGRAM_INT16, 1));
    arrays.back().name = "segmentation";
    arrays.back().description = "what each camera sees: index into segmentation_names";
  }
}

engram_array mask_array(const Batch& env) {
  engram_array array{};
  array.name = "final_mask";
  array.unit = "";
  array.description = "an episode ended in this step, and its final outputs are kept";
  array.data = env.final_mask().data();
  array.dtype = ENGRAM_BOOL;
  array.ndim = 1;
  array.shape[0] = env.num_envs();
  return array;
}

// at: the column of these or of the final outputs.
template <class At>
std::vector<engram_array> list_columns(const Batch& env, At&& at) {
  std::vector<engram_array> arrays;
  for (std::size_t i = 0; i < env.outputs().size(); ++i) {
    const ColumnView column = env.outputs()[i];
    arrays.push_back(column_array(at(column), env.num_envs()));
    // Without a state observation its rows are empty.
    if (column.field->name == "observation" && env.observation().empty()) {
      arrays.back().ndim = 2;
      arrays.back().shape[1] = 0;
    }
  }
  return arrays;
}

}  // namespace

std::vector<engram_array> list_outputs(const Batch& env) {
  std::vector<engram_array> arrays = list_columns(
      env, [&env](const ColumnView& column) { return env.output(column.field->name); });
  arrays.push_back(mask_array(env));
  add_images(env, env.images(), arrays);
  return arrays;
}

std::vector<engram_array> list_final_outputs(const Batch& env) {
  if (env.options().auto_reset != AutoReset::kSameStep) return {};
  std::vector<engram_array> arrays = list_columns(
      env, [&env](const ColumnView& column) { return env.final_output(column.field->name); });
  add_images(env, env.final_images(), arrays);
  return arrays;
}

engram_status refuse_null(const char* what) noexcept {
  return guarded([what] {
    throw Error(Error::kInvalidArgument, std::string(what) + ": NULL given, an address needed");
  });
}

engram_status refuse_busy(Use found) noexcept {
  return fail(ENGRAM_BAD_STATE, found == Use::kStepping
                                    ? "a step is under way; wait for it first"
                                    : "this batch is at work in another thread; use it from one "
                                      "thread at a time");
}

engram_status refuse_forked(const engram_env& env) noexcept {
  return guarded([&env] {
    throw Error(Error::kBadState,
                "this batch was made in process " + std::to_string(env.owner) +
                    ", whose threads do not survive a fork; make one in process " +
                    std::to_string(::getpid()));
  });
}

}  // namespace engram::c

engram_env::engram_env(std::unique_ptr<engram::Batch> made)
    : batch(std::move(made)),
      queries(*batch),
      renderer(*batch),
      snapshotter(*batch),
      actions(static_cast<std::size_t>(batch->num_envs()) *
              static_cast<std::size_t>(batch->action_dim())),
      outputs(engram::c::list_outputs(*batch)),
      final_outputs(engram::c::list_final_outputs(*batch)) {}

std::span<const float> engram_env::copied(std::span<const float> given) {
  if (given.size() != actions.size()) return given;
  std::ranges::copy(given, actions.begin());
  return actions;
}
