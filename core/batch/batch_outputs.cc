#include "core/batch/batch_outputs.h"

#include <algorithm>
#include <cstring>

#include "core/base/error.h"

namespace engram {
namespace {

constexpr std::string_view kRow = BatchData::kObservation;
constexpr std::string_view kCue = "task_cue";
constexpr const char* kTaskIndex = "task_index";
constexpr const char* kObjectMask = "object_mask";

bool is_image(const OutputArray& array) { return array.shape.size() == 4; }

// Arrays that are filled without copies: images, and constants.
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

bool observes_cue(const BatchData& data) { return data.info().task_cue_dim > 0; }

std::vector<RangedField> row_of(const BatchData& data) {
  if (data.objects) return data.objects->ranged_fields();
  std::vector<RangedField> fields;
  if (!observes_state(data.options.obs_mode)) return fields;
  for (const Field& field : data.state_fields) fields.emplace_back().field = field;
  return fields;
}

auto find_field(std::vector<RangedField>& fields, std::string_view name) {
  return std::ranges::find_if(
      fields, [name](const RangedField& field) { return field.field.name == name; });
}

// An array without data. Members are set one by one: GCC 12 destroys members of nested braces twice
// where memory runs out in between.
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

// Outputs in the order of users' lists: columns, final_mask, images.
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

// Those that final outputs have; empty unless the batch keeps any.
std::vector<OutputArray> final_output_arrays(const BatchData& data) {
  if (data.options.auto_reset != AutoReset::kSameStep) return {};
  std::vector<OutputArray> arrays = column_arrays(
      data, data.final_outputs, data.objects ? data.objects->final_rows() : ColumnView());
  add_images(
      data, [](const auto& images) { return images.finals(); }, arrays);
  return arrays;
}

}  // namespace

const OutputArray* find_array(const std::vector<OutputArray>& arrays, std::string_view name) {
  const auto found = std::ranges::find_if(
      arrays, [name](const OutputArray& array) { return array.field.name == name; });
  return found != arrays.end() ? &*found : nullptr;
}

std::vector<RangedField> merged_rows(std::span<const std::vector<RangedField>> rows) {
  std::vector<RangedField> fields;
  for (const std::vector<RangedField>& row : rows) {
    auto next = fields.begin();  // where this row's next field goes, if it is new
    for (const RangedField& field : row) {
      auto found = find_field(fields, field.field.name);
      if (found == fields.end()) {
        found = fields.insert(next, field);
      } else {
        found->field.width = std::max(found->field.width, field.field.width);
        if (found->field.description != field.field.description) found->field.description.clear();
      }
      next = found + 1;
    }
  }
  return fields;
}

int row_width(std::span<const RangedField> fields) {
  int width = 0;
  for (const RangedField& field : fields) width += field.field.width;
  return width;
}

int offset_of(std::string_view name, std::span<const RangedField> fields) {
  for (std::size_t i = 0; i < fields.size(); ++i) {
    if (fields[i].field.name == name) return row_width(fields.first(i));
  }
  throw Error(Error::kInternal, "no field '" + std::string(name) + "' in the common rows");
}

int count_tokens(std::span<const RangedField> fields) {
  return static_cast<int>(std::ranges::count_if(fields, [](const RangedField& field) {
    return field.field.name.starts_with("object_") && field.field.name.ends_with("_seen");
  }));
}

BatchOutputs::BatchOutputs(std::span<BatchData* const> parts, bool common) : common_(common) {
  std::vector<std::vector<RangedField>> rows;
  for (BatchData* const data : parts) {
    rows.push_back(row_of(*data));
    Part& part = parts_.emplace_back();
    part.data = data;
    part.now = output_arrays(*data);
    part.finals = final_output_arrays(*data);
    part.row = rows.back();
    num_envs_ += data->num_envs();
    any_cue_ |= observes_cue(*data);
  }
  row_ = merged_rows(rows);
  set_turns(1);
  now_ = merged(&Part::now);
  finals_ = merged(&Part::finals);
  if (!common_) return;
  add_constants();
  allocate(now_);
  allocate(finals_);
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    Part& part = parts_[i];
    if (part.data->images) {
      part.data->images->draw_into(images_in(part, now_), images_in(part, finals_));
    }
    fill_constants(part, static_cast<int>(i));
    add_common_copies(part, part.copies[0]);
  }
  use_buffer();
}

// All outputs of that list, in the order of the first part that has them.
std::vector<OutputArray> BatchOutputs::merged(std::vector<OutputArray> Part::*list) const {
  std::vector<OutputArray> arrays;
  for (std::size_t part = 0; part < parts_.size(); ++part) {
    for (const OutputArray& array : parts_[part].*list) {
      if (!has(part, array.field.name)) continue;
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
    if (array.field.name == kRow && !row_.empty()) widen(array, row_width(row_));
  }
  return arrays;
}

bool BatchOutputs::has(std::size_t part, std::string_view name) const {
  return !hides_cue(parts_[part], name) && find_array(parts_[part].now, name) != nullptr;
}

// Other quantities of the cue's name are left out where tasks have a cue that policies may see.
bool BatchOutputs::hides_cue(const Part& part, std::string_view name) const {
  return name == kCue && any_cue_ && !observes_cue(*part.data);
}

void BatchOutputs::add_constants() {
  now_.push_back(make_output_array(kTaskIndex, 1, DType::kInt32, "",
                                   "number of the environment's task", num_envs_));
  const int tokens = count_tokens(row_);
  if (tokens == 0) return;
  now_.push_back(make_output_array(kObjectMask, tokens, DType::kBool, "",
                                   "1: the task has this object", num_envs_));
  widen(now_.back(), tokens);
}

void BatchOutputs::fill_constants(const Part& part, int index) const {
  auto* const indices =
      reinterpret_cast<std::int32_t*>(find_array(now_, kTaskIndex)->data) + part.data->first_env;
  std::fill_n(indices, part.data->num_envs(), static_cast<std::int32_t>(index));
  const OutputArray* const mask = find_array(now_, kObjectMask);
  if (mask == nullptr) return;
  const auto tokens = at(count_tokens(part.row));
  for (int env = 0; env < part.data->num_envs(); ++env) {
    std::memset(mask->data + at(part.data->first_env + env) * mask->row_bytes(), 1, tokens);
  }
}

void BatchOutputs::allocate(std::vector<OutputArray>& arrays) {
  for (OutputArray& array : arrays) {
    array.data = memory_.emplace_back(array.row_bytes() * at(num_envs_)).data();
  }
}

void BatchOutputs::add_common_copies(Part& part, OutputCopies& copies) const {
  if (!common_) return;
  for (const OutputArray& array : now_) {
    if (is_copied(array)) add_copies(part, part.now, array, &OutputCopies::add, copies);
  }
  for (const OutputArray& array : finals_) {
    if (!is_image(array)) add_copies(part, part.finals, array, &OutputCopies::add_final, copies);
  }
}

// Copies of one of a task's own arrays into a part of another one, if the task has it.
void BatchOutputs::add_copies(const Part& part, const std::vector<OutputArray>& own,
                              const OutputArray& to, void (OutputCopies::*add)(const RowCopy&),
                              OutputCopies& copies) const {
  const OutputArray* const from = find_array(own, to.field.name);
  if (from == nullptr || hides_cue(part, to.field.name)) return;
  RowCopy copy;
  copy.from = from->data;
  copy.to = to.data + at(part.data->first_env) * to.row_bytes();
  copy.from_row = from->row_bytes();
  copy.to_row = to.row_bytes();
  copy.bytes = from->row_bytes();
  copy.int_to_float = from->field.dtype == DType::kInt32 && to.field.dtype == DType::kFloat32;
  if (to.field.name != kRow) {
    (copies.*add)(copy);
    return;
  }
  std::size_t offset = 0;
  for (const RangedField& field : part.row) {
    RowCopy one = copy;
    one.from += offset;
    one.to += sizeof(float) * at(offset_of(field.field.name, row_));
    one.bytes = sizeof(float) * at(field.field.width);
    offset += one.bytes;
    (copies.*add)(one);
  }
}

ImageTargets BatchOutputs::images_in(const Part& part, const std::vector<OutputArray>& arrays) {
  const auto rows_of = [&](const char* name) -> std::byte* {
    const OutputArray* const array = find_array(arrays, name);
    if (array == nullptr || array->data == nullptr) return nullptr;
    return array->data + at(part.data->first_env) * array->row_bytes();
  };
  return {reinterpret_cast<std::uint8_t*>(rows_of("rgb")),
          reinterpret_cast<std::int16_t*>(rows_of("depth")),
          reinterpret_cast<std::int16_t*>(rows_of("segmentation"))};
}

// --- callers' arrays ---

void BatchOutputs::check(std::span<const OutputTarget> targets) const {
  for (std::size_t i = 0; i < targets.size(); ++i) {
    const OutputTarget& target = targets[i];
    const OutputArray* const array = find_array(now_, target.name);
    if (array == nullptr) {
      throw Error(Error::kUnknownId, "no output named '" + target.name + "' to be written");
    }
    const std::size_t needed = array->row_bytes() * at(num_envs_);
    if (target.data == nullptr || target.bytes != needed) {
      throw Error(Error::kInvalidArgument,
                  "array for " + target.name + ": " +
                      (target.data == nullptr ? std::string("no address")
                                              : std::to_string(target.bytes) + " bytes") +
                      " given, " + std::to_string(needed) + " bytes needed");
    }
    for (const OutputTarget& earlier : targets.first(i)) {
      if (earlier.name == target.name) {
        throw Error(Error::kInvalidArgument,
                    "two arrays for " + target.name + " given, one allowed");
      }
    }
  }
}

void BatchOutputs::write_to(std::span<const std::vector<OutputTarget>> turns) {
  if (turns.empty()) throw Error(Error::kInvalidArgument, "0 turns of arrays given, 1 needed");
  for (const std::vector<OutputTarget>& targets : turns) {
    check(targets);
    if (!std::ranges::is_permutation(targets, turns[0], {}, &OutputTarget::name,
                                     &OutputTarget::name)) {
      throw Error(Error::kInvalidArgument,
                  "arrays that take turns: all turns must be for the same outputs");
    }
  }
  buffer_ = 0;
  set_turns(turns.size());
  for (std::size_t turn = 0; turn < turns.size(); ++turn) add_targets(turns[turn], turn);
  for (Part& part : parts_) {
    if (part.data->images) part.data->images->draw_into(part.images[0], {});
  }
  use_buffer();
}

void BatchOutputs::set_turns(std::size_t count) {
  user_images_.assign(count, {});
  for (Part& part : parts_) {
    part.copies.assign(count, {});
    part.images.assign(count, {});
  }
}

void BatchOutputs::add_targets(std::span<const OutputTarget> targets, std::size_t turn) {
  std::vector<OutputArray> arrays;  // the callers'
  for (const OutputTarget& target : targets) {
    const OutputArray* const array = find_array(now_, target.name);
    arrays.push_back(*array);
    arrays.back().data = static_cast<std::byte*>(target.data);
    if (is_image(*array)) {
      user_images_[turn].emplace_back(array - now_.data(), arrays.back().data);
    }
  }
  for (Part& part : parts_) {
    add_common_copies(part, part.copies[turn]);
    part.images[turn] = images_in(part, arrays);
    for (const OutputArray& array : arrays) {
      if (!is_image(array)) {
        add_copies(part, part.now, array, &OutputCopies::add, part.copies[turn]);
      }
    }
  }
}

void BatchOutputs::next_buffer() {
  if (user_images_.size() == 1) return;
  buffer_ = (buffer_ + 1) % user_images_.size();
  for (Part& part : parts_) {
    if (part.data->images) part.data->images->swap_to(part.images[buffer_]);
  }
  use_buffer();
}

void BatchOutputs::use_buffer() {
  for (Part& part : parts_) part.data->copies = &part.copies[buffer_];
  for (const auto& [output, data] : user_images_[buffer_]) now_[output].data = data;
}

}  // namespace engram
