#include "protocol/datasets/labels.h"

#include <algorithm>
#include <array>
#include <limits>

#include "core/base/error.h"
#include "core/batch/queries.h"
#include "protocol/make/rows.h"

namespace engram {
namespace {

// What one camera sees of an object.
struct Sighting {
  std::array<std::int32_t, EpisodeLabels::kBox> box = {-1, -1, -1, -1};
  std::array<std::int32_t, EpisodeLabels::kPoint> point = {-1, -1, -1};
};

// Images of one environment: a value per row, column and camera.
struct Cells {
  std::span<const std::int16_t> values;
  int width = 0;
  int cameras = 0;

  std::int16_t at(int row, int column, int camera) const {
    return values[static_cast<std::size_t>((row * width + column) * cameras + camera)];
  }
};

Sighting look_for(std::int16_t segment, const Cells& segmentation, const Cells& depth, int height,
                  int camera) {
  Sighting seen;
  auto& [left, top, right, bottom] = seen.box;
  std::int64_t count = 0;
  std::int64_t columns = 0;
  std::int64_t rows = 0;
  for (int row = 0; row < height; ++row) {
    for (int column = 0; column < segmentation.width; ++column) {
      if (segmentation.at(row, column, camera) != segment) continue;
      left = count == 0 ? column : std::min(left, column);
      top = count == 0 ? row : top;
      right = std::max(right, column + 1);
      bottom = row + 1;
      ++count;
      columns += column;
      rows += row;
    }
  }
  if (count == 0) return seen;
  // The middle may be a hole, or hidden by something.
  std::int64_t least = std::numeric_limits<std::int64_t>::max();
  for (int row = top; row < bottom; ++row) {
    for (int column = left; column < right; ++column) {
      if (segmentation.at(row, column, camera) != segment) continue;
      const std::int64_t x = column * count - columns;
      const std::int64_t y = row * count - rows;
      if (x * x + y * y >= least) continue;
      least = x * x + y * y;
      seen.point = {column, row, depth.at(row, column, camera)};
    }
  }
  return seen;
}

template <class T>
std::int64_t size_of(const std::vector<T>& values) {
  return static_cast<std::int64_t>(values.size());
}

}  // namespace

std::vector<std::string> privileged_labels(const TaskInfo& info) {
  std::vector<std::string> names = {"subtask_index", "is_keyframe", "progress",
                                    "object_index",  "object_box",  "object_point"};
  const std::vector<std::string> answers = {"answered", "first_answer", "first_answer_correct"};
  if (!info.answer.empty()) names.insert(names.end(), answers.begin(), answers.end());
  for (const char* name :
       {"plan", "plan_step", "plan_index", "memory", "memory_step", "object_names"}) {
    names.emplace_back(name);
  }
  return names;
}

// --- recording ---

void LabelRecorder::start(const Batch& batch, int index) {
  const Queries queries(batch);
  if (queries.annotator() == nullptr) {
    throw Error(Error::kUnavailable, batch.info().id + " has no words for its episodes: no labels");
  }
  labels_ = {};
  plan_.clear();
  answers_ = !batch.info().answer.empty();
  labels_.paraphrases = queries.paraphrases(index);
  segment_.clear();
  const auto names = batch.images().segmentation_names;
  for (const PropModel& prop : batch.physics_model().props()) {
    const auto found = std::find(names.begin(), names.end(), prop.name);
    segment_.push_back(found == names.end() ? std::int16_t{-1}
                                            : static_cast<std::int16_t>(found - names.begin()));
    labels_.object_names.push_back(prop.name);
  }
}

void LabelRecorder::before_step(const Batch& batch, int index) {
  note_words(batch, index);
  note_object(batch, index, labels_.object_index.back());
}

void LabelRecorder::note_words(const Batch& batch, int index) {
  const Annotator& annotator = *Queries(batch).annotator();
  const auto step = static_cast<std::int32_t>(labels_.subtask_index.size());
  const auto subtask = static_cast<std::int32_t>(annotator.subtask(index));
  std::vector<std::string> plan = annotator.plan(index);
  const auto at = static_cast<std::size_t>(subtask);
  const bool first = step == 0;
  const bool changed = first || subtask != labels_.subtask_index.back() ||
                       plan[at] != plan_[static_cast<std::size_t>(labels_.subtask_index.back())];
  if (first || plan != plan_) {
    for (std::size_t i = 0; i < plan.size(); ++i) {
      labels_.plan.push_back(plan[i]);
      labels_.plan_step.push_back(step);
      labels_.plan_index.push_back(static_cast<std::int32_t>(i));
    }
    plan_ = std::move(plan);
  }
  std::string memory = annotator.memory(index);
  const bool known = !labels_.memory.empty();
  if (known ? memory != labels_.memory.back() : !memory.empty()) {
    labels_.memory.push_back(std::move(memory));
    labels_.memory_step.push_back(step);
  }
  const float done =
      static_cast<float>(annotator.subtasks_done(index)) / static_cast<float>(plan_.size());
  labels_.progress.push_back(first ? done : std::max(done, labels_.progress.back()));
  labels_.subtask_index.push_back(subtask);
  labels_.is_keyframe.push_back(changed ? 1 : 0);
  labels_.object_index.push_back(static_cast<std::int32_t>(annotator.object(index)));
}

void LabelRecorder::note_object(const Batch& batch, int index, int prop) {
  const ImageShape& shape = batch.options().images;
  const std::int16_t segment =
      prop < 0 ? std::int16_t{-1} : segment_[static_cast<std::size_t>(prop)];
  const Cells segmentation{row_of(batch.images().segmentation, batch, index), shape.width,
                           EpisodeLabels::kCameras};
  const Cells depth{row_of(batch.images().depth, batch, index), shape.width,
                    EpisodeLabels::kCameras};
  for (int camera = 0; camera < EpisodeLabels::kCameras; ++camera) {
    const Sighting seen =
        segment < 0 ? Sighting() : look_for(segment, segmentation, depth, shape.height, camera);
    labels_.object_box.insert(labels_.object_box.end(), seen.box.begin(), seen.box.end());
    labels_.object_point.insert(labels_.object_point.end(), seen.point.begin(), seen.point.end());
  }
}

void LabelRecorder::after_step(const Batch& batch, int index) {
  if (!answers_) return;
  const auto flag = [&](const char* name) {
    return value_of<std::uint8_t>(batch.output(name), index);
  };
  const bool answers_now =
      flag("answered") != 0 && (labels_.answered.empty() || labels_.answered.back() == 0);
  if (answers_now) labels_.is_keyframe.back() = 1;
  labels_.answered.push_back(flag("answered"));
  labels_.first_answer.push_back(value_of<std::int32_t>(batch.output("first_answer"), index));
  labels_.first_answer_correct.push_back(flag("first_answer_correct"));
}

// --- arrays ---

LabelArrays::LabelArrays(const EpisodeLabels& labels) {
  constexpr int kTexts = 4;
  storage_.reserve(kTexts);
  const std::int64_t steps = size_of(labels.subtask_index);
  constexpr std::int64_t kCameras = EpisodeLabels::kCameras;
  const auto numbers = [&](const char* name, const std::vector<std::int32_t>& values) {
    arrays_.push_back({name, NpyType::kInt32, {size_of(values)}, bytes_of(values)});
  };
  const auto flags = [&](const char* name, const std::vector<std::uint8_t>& values) {
    arrays_.push_back({name, NpyType::kBool, {size_of(values)}, bytes_of(values)});
  };
  numbers("subtask_index", labels.subtask_index);
  flags("is_keyframe", labels.is_keyframe);
  arrays_.push_back({"progress", NpyType::kFloat32, {steps}, bytes_of(labels.progress)});
  numbers("object_index", labels.object_index);
  arrays_.push_back({"object_box",
                     NpyType::kInt32,
                     {steps, kCameras, EpisodeLabels::kBox},
                     bytes_of(labels.object_box)});
  arrays_.push_back({"object_point",
                     NpyType::kInt32,
                     {steps, kCameras, EpisodeLabels::kPoint},
                     bytes_of(labels.object_point)});
  if (!labels.answered.empty()) {
    flags("answered", labels.answered);
    numbers("first_answer", labels.first_answer);
    flags("first_answer_correct", labels.first_answer_correct);
  }
  add_texts("plan", labels.plan);
  numbers("plan_step", labels.plan_step);
  numbers("plan_index", labels.plan_index);
  add_texts("memory", labels.memory);
  numbers("memory_step", labels.memory_step);
  add_texts("object_names", labels.object_names);
  add_texts("paraphrases", labels.paraphrases);
}

void LabelArrays::add_texts(const char* name, const std::vector<std::string>& texts) {
  arrays_.push_back(text_array(name, texts, storage_.emplace_back()));
}

}  // namespace engram
