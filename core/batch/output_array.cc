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
void add_images_of(const BatchData& data, std::span<const T> values, OutputArray about,
                   std::vector<OutputArray>& arrays) {
  if (values.empty()) return;
  const ImageShape& shape = data.options.images;
  about.shape.push_back(shape.height);
  about.shape.push_back(shape.width);
  about.shape.push_back(about.field.width * static_cast<std::int64_t>(shape.cameras.size()));
  about.field.width = static_cast<int>(values.size() / at(data.num_envs()));
  about.data = reinterpret_cast<std::byte*>(const_cast<T*>(values.data()));
  arrays.push_back(std::move(about));
}

// Adds images of one kind each; of(images): those of now, or of the last episodes' ends.
template <class Of>
void add_images(const BatchData& data, Of&& of, std::vector<OutputArray>& arrays) {
  if (!data.images) return;
  const int num_envs = data.num_envs();
  add_images_of(data, of(data.images->rgb()),
                make_output_array(
                    "rgb", 3, DType::kUInt8, "",
                    "images, row 0 on top, cameras one behind the other in each pixel", num_envs),
                arrays);
  add_images_of(data, of(data.images->depth()),
                make_output_array("depth", 1, DType::kInt16, "mm",
                                  "along the axis of each camera; 0: nothing there", num_envs),
                arrays);
  add_images_of(data, of(data.images->segmentation()),
                make_output_array("segmentation", 1, DType::kInt16, "",
                                  "what each camera sees: index into segmentation_names", num_envs),
                arrays);
}

// rows: the view of the observation in objects modes.
std::vector<OutputArray> column_arrays(const BatchData& data, const ColumnStore& store,
                                       const ColumnView& rows) {
  std::vector<OutputArray> arrays;
  for (std::size_t i = 0; i < store.size(); ++i) {
    const bool is_row = store[i].field->name == BatchData::kObservation;
    arrays.push_back(column_array(is_row && data.objects ? rows : store[i], data.num_envs()));
    if (!is_row || data.objects || observes_state(data.options.obs_mode)) continue;
    OutputArray& array = arrays.back();
    array.field.width = 0;
    array.shape.resize(1);
    array.shape.push_back(0);
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

std::vector<OutputArray> output_arrays(const BatchData& data) {
  std::vector<OutputArray> arrays =
      column_arrays(data, data.outputs, data.objects ? data.objects->rows() : ColumnView());
  OutputArray mask = make_output_array(
      "final_mask", 1, DType::kBool, "",
      "an episode ended in this step, and its final outputs are kept", data.num_envs());
  mask.data = reinterpret_cast<std::byte*>(const_cast<std::uint8_t*>(data.final_mask.data()));
  arrays.push_back(std::move(mask));
  add_images(
      data, [](const auto& images) { return images.now(); }, arrays);
  return arrays;
}

std::vector<OutputArray> final_output_arrays(const BatchData& data) {
  if (data.options.auto_reset != AutoReset::kSameStep) return {};
  std::vector<OutputArray> arrays = column_arrays(
      data, data.final_outputs, data.objects ? data.objects->final_rows() : ColumnView());
  add_images(
      data, [](const auto& images) { return images.finals(); }, arrays);
  return arrays;
}

const OutputArray* find_array(const std::vector<OutputArray>& arrays, std::string_view name) {
  const auto found = std::ranges::find_if(
      arrays, [name](const OutputArray& array) { return array.field.name == name; });
  return found != arrays.end() ? &*found : nullptr;
}

}  // namespace engram
