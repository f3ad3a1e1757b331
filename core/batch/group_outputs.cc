#include "core/batch/group_outputs.h"

#include <algorithm>
#include <cstring>

namespace engram {
namespace {

constexpr std::string_view kRow = "observation";
constexpr std::string_view kCue = "task_cue";
constexpr const char* kTaskIndex = "task_index";
constexpr const char* kObjectMask = "object_mask";

bool is_image(const OutputArray& array) { return array.shape.size() == 4; }

// Arrays that batches fill themselves, without copies: images, and constants of the group.
bool is_copied(const OutputArray& array) {
  return !is_image(array) && array.field.name != kTaskIndex && array.field.name != kObjectMask;
}

void widen(OutputArray& array, int width) {
  array.field.width = width;
  array.shape.resize(1);
  if (width != 1) array.shape.push_back(width);
}

void merge_into(OutputArray& into, const OutputArray& array) {
  if (!is_image(into) && array.field.width > into.field.width) widen(into, array.field.width);
  if (array.field.dtype != into.field.dtype) into.field.dtype = DType::kFloat32;
  if (array.field.description != into.field.description) into.field.description.clear();
  into.field.privileged |= array.field.privileged;
}

// The cue that policies may see, where a task has one.
bool observes_cue(const Batch& batch) { return batch.info().task_cue_dim > 0; }

}  // namespace

GroupOutputs::GroupOutputs(const std::vector<GroupPart>& parts, bool common)
    : parts_(parts), common_(common), layout_({}) {
  std::vector<std::vector<RangedField>> rows;
  for (const GroupPart& part : parts_) {
    num_envs_ += part.batch->num_envs();
    rows.push_back(engram::row_fields(*part.batch));
    Source& source = sources_.emplace_back();
    source.now = output_arrays(*part.batch);
    source.finals = final_output_arrays(*part.batch);
    source.row = rows.back();
  }
  layout_ = RowLayout(rows);
  any_cue_ =
      std::ranges::any_of(parts_, [](const GroupPart& part) { return observes_cue(*part.batch); });
  arrays_ = merged(&Source::now);
  finals_ = merged(&Source::finals);
  if (!common_) return;
  add_constants();
  allocate(arrays_);
  allocate(finals_);
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    Batch& batch = *parts_[i].batch;
    batch.draw_into(images_in(i, arrays_), images_in(i, finals_));
    const auto index = static_cast<std::int32_t>(i);
    auto* const indices =
        reinterpret_cast<std::int32_t*>(find_array(arrays_, kTaskIndex)->data) + parts_[i].first;
    std::fill_n(indices, batch.num_envs(), index);
    const OutputArray* const mask = find_array(arrays_, kObjectMask);
    if (mask == nullptr) continue;
    const auto tokens = static_cast<std::size_t>(count_tokens(sources_[i].row));
    for (int env = 0; env < batch.num_envs(); ++env) {
      const auto row = static_cast<std::size_t>(parts_[i].first + env);
      std::memset(mask->data + row * mask->row_bytes(), 1, tokens);
    }
  }
}

// All outputs of that list, in the order of the first part that has them.
std::vector<OutputArray> GroupOutputs::merged(std::vector<OutputArray> Source::*list) const {
  std::vector<OutputArray> arrays;
  for (std::size_t part = 0; part < parts_.size(); ++part) {
    for (const OutputArray& array : sources_[part].*list) {
      if (!shares(part, array.field.name)) continue;
      const auto found = std::ranges::find_if(
          arrays, [&array](const OutputArray& one) { return one.field.name == array.field.name; });
      if (found == arrays.end()) {
        arrays.push_back(array);
      } else {
        merge_into(*found, array);
      }
    }
  }
  for (OutputArray& array : arrays) {
    array.shape[0] = num_envs_;
    if (array.field.name == kRow && layout_.width() > 0) widen(array, layout_.width());
  }
  return arrays;
}

// Other quantities of the same name are left out where tasks have a cue that policies may see.
bool GroupOutputs::shares(std::size_t part, std::string_view name) const {
  return name != kCue || !any_cue_ || observes_cue(*parts_[part].batch);
}

void GroupOutputs::add_constants() {
  arrays_.push_back(make_output_array(kTaskIndex, 1, DType::kInt32, "",
                                      "number of the environment's task", num_envs_));
  const int tokens = count_tokens(layout_.fields());
  if (tokens == 0) return;
  arrays_.push_back(make_output_array(kObjectMask, tokens, DType::kBool, "",
                                      "1: the task has this object", num_envs_));
  widen(arrays_.back(), tokens);
}

void GroupOutputs::allocate(std::vector<OutputArray>& arrays) {
  for (OutputArray& array : arrays) {
    const std::size_t size = array.row_bytes() * static_cast<std::size_t>(num_envs_);
    array.data = memory_.emplace_back(size).data();
  }
}

bool GroupOutputs::has(std::size_t part, std::string_view name) const {
  const OutputArray* const array = find_array(arrays_, name);
  if (array == nullptr) return false;
  if (!is_copied(*array)) return true;
  return shares(part, name) && find_array(sources_[part].now, name) != nullptr;
}

void GroupOutputs::add_copies(std::size_t part, OutputCopies& copies) const {
  if (!common_) return;
  for (const OutputArray& array : arrays_) {
    if (is_copied(array)) add_copies_into(part, array, array.data, copies);
  }
  for (const OutputArray& array : finals_) {
    const OutputArray* const from = find_array(sources_[part].finals, array.field.name);
    if (is_image(array) || from == nullptr || !has(part, array.field.name)) continue;
    add(part, *from, array, array.data, &OutputCopies::add_final, copies);
  }
}

void GroupOutputs::add_copies_into(std::size_t part, const OutputArray& array, std::byte* to,
                                   OutputCopies& copies) const {
  const OutputArray* const from = find_array(sources_[part].now, array.field.name);
  if (from == nullptr || !has(part, array.field.name)) return;
  add(part, *from, array, to, &OutputCopies::add, copies);
}

// Copies of one output of a part into an array of the group.
void GroupOutputs::add(std::size_t part, const OutputArray& from, const OutputArray& array,
                       std::byte* to, void (OutputCopies::*add_copy)(const RowCopy&),
                       OutputCopies& copies) const {
  RowCopy copy;
  copy.from = from.data;
  copy.to = to + static_cast<std::size_t>(parts_[part].first) * array.row_bytes();
  copy.from_row = from.row_bytes();
  copy.to_row = array.row_bytes();
  copy.bytes = from.row_bytes();
  copy.int_to_float = from.field.dtype == DType::kInt32 && array.field.dtype == DType::kFloat32;
  if (array.field.name != kRow) {
    (copies.*add_copy)(copy);
    return;
  }
  std::size_t offset = 0;
  for (const RangedField& field : sources_[part].row) {
    RowCopy one = copy;
    one.from += offset;
    one.to += sizeof(float) * static_cast<std::size_t>(layout_.offset_of(field.field.name));
    one.bytes = sizeof(float) * static_cast<std::size_t>(field.field.width);
    offset += one.bytes;
    (copies.*add_copy)(one);
  }
}

ImageTargets GroupOutputs::images_in(std::size_t part,
                                     const std::vector<OutputArray>& arrays) const {
  const auto rows_of = [&](const char* name) -> std::byte* {
    const OutputArray* const array = find_array(arrays, name);
    if (array == nullptr || array->data == nullptr) return nullptr;
    return array->data + static_cast<std::size_t>(parts_[part].first) * array->row_bytes();
  };
  return {reinterpret_cast<std::uint8_t*>(rows_of("rgb")),
          reinterpret_cast<std::int16_t*>(rows_of("depth")),
          reinterpret_cast<std::int16_t*>(rows_of("segmentation"))};
}

}  // namespace engram
