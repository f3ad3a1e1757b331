#include "core/batch/output_array.h"

#include <algorithm>

namespace engram {
namespace {

OutputArray column_array(const ColumnView& column, int num_envs) {
  OutputArray array;
  array.field = *column.field;
  array.shape.push_back(num_envs);
  if (array.field.width > 1) array.shape.push_back(array.field.width);
  array.data = column.data;
  return array;
}

// about: one value of a pixel for each camera. Cameras stand one behind the other.
template <class T>
void add_images(const Batch& batch, std::span<const T> values, OutputArray about,
                std::vector<OutputArray>& arrays) {
  if (values.empty()) return;
  const ImageShape& shape = batch.options().images;
  about.shape.push_back(shape.height);
  about.shape.push_back(shape.width);
  about.shape.push_back(about.field.width * static_cast<std::int64_t>(shape.cameras.size()));
  about.field.width = static_cast<int>(values.size() / static_cast<std::size_t>(batch.num_envs()));
  about.data = reinterpret_cast<std::byte*>(const_cast<T*>(values.data()));
  arrays.push_back(std::move(about));
}

void add_images(const Batch& batch, const ObservedImages& images,
                std::vector<OutputArray>& arrays) {
  const int num_envs = batch.num_envs();
  add_images(batch, images.rgb,
             make_output_array("rgb", 3, DType::kUInt8, "",
                               "images, row 0 on top, cameras one behind the other in each pixel",
                               num_envs),
             arrays);
  add_images(batch, images.depth,
             make_output_array("depth", 1, DType::kInt16, "mm",
                               "along the axis of each camera; 0: nothing there", num_envs),
             arrays);
  add_images(batch, images.segmentation,
             make_output_array("segmentation", 1, DType::kInt16, "",
                               "what each camera sees: index into segmentation_names", num_envs),
             arrays);
}

// at: the column of these or of the final outputs.
template <class At>
std::vector<OutputArray> column_arrays(const Batch& batch, At&& at) {
  std::vector<OutputArray> arrays;
  for (std::size_t i = 0; i < batch.outputs().size(); ++i) {
    arrays.push_back(column_array(at(batch.outputs()[i]), batch.num_envs()));
    // Without a state observation its rows are empty.
    OutputArray& array = arrays.back();
    if (array.field.name == "observation" && batch.observation().empty()) {
      array.field.width = 0;
      array.shape.resize(1);
      array.shape.push_back(0);
    }
  }
  return arrays;
}

}  // namespace

OutputArray make_output_array(const char* name, int width, DType dtype, const char* unit,
                              const char* description, int num_envs) {
  OutputArray array;
  array.field.name = name;
  array.field.width = width;
  array.field.dtype = dtype;
  array.field.unit = unit;
  array.field.description = description;
  array.shape.push_back(num_envs);
  return array;
}

std::vector<OutputArray> output_arrays(const Batch& batch) {
  std::vector<OutputArray> arrays = column_arrays(
      batch, [&batch](const ColumnView& column) { return batch.output(column.field->name); });
  OutputArray mask = make_output_array(
      "final_mask", 1, DType::kBool, "",
      "an episode ended in this step, and its final outputs are kept", batch.num_envs());
  mask.data = reinterpret_cast<std::byte*>(const_cast<std::uint8_t*>(batch.final_mask().data()));
  arrays.push_back(std::move(mask));
  add_images(batch, batch.images(), arrays);
  return arrays;
}

std::vector<OutputArray> final_output_arrays(const Batch& batch) {
  if (batch.options().auto_reset != AutoReset::kSameStep) return {};
  std::vector<OutputArray> arrays = column_arrays(
      batch, [&batch](const ColumnView& column) { return batch.final_output(column.field->name); });
  add_images(batch, batch.final_images(), arrays);
  return arrays;
}

const OutputArray* find_array(const std::vector<OutputArray>& arrays, std::string_view name) {
  const auto found = std::ranges::find_if(
      arrays, [name](const OutputArray& array) { return array.field.name == name; });
  return found != arrays.end() ? &*found : nullptr;
}

}  // namespace engram
