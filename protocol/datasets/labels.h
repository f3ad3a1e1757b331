// Labels of a demonstration: its subtasks, plan and memory in words, and where cameras see the
// object that is meant (docs/datasets.md). Privileged, apart from the paraphrases.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "core/batch/batch.h"
#include "protocol/datasets/npz.h"

namespace engram {

// Lists of steps have an entry for each; step t begins with frame t.
struct EpisodeLabels {
  static constexpr int kCameras = 2;
  static constexpr int kBox = 4;    // x0, y0, x1, y1: pixels, the end behind the last
  static constexpr int kPoint = 3;  // column, row, depth in mm

  std::vector<std::int32_t> subtask_index;  // in the plan of that frame
  std::vector<std::uint8_t> is_keyframe;
  std::vector<float> progress;             // 0..1, never falls
  std::vector<std::int32_t> object_index;  // -1: none
  std::vector<std::int32_t> object_box;    // (kCameras * kBox) per step, -1: not in view
  std::vector<std::int32_t> object_point;  // (kCameras * kPoint) per step, likewise
  std::vector<std::uint8_t> answered;      // after the action, as the next two
  std::vector<std::int32_t> first_answer;
  std::vector<std::uint8_t> first_answer_correct;
  // Wordings of subtasks, and the frame from which on they hold. All subtasks are there once more
  // whenever the words of one change.
  std::vector<std::string> plan;
  std::vector<std::int32_t> plan_step;
  std::vector<std::int32_t> plan_index;
  // What is known of hidden quantities, each until the next one.
  std::vector<std::string> memory;
  std::vector<std::int32_t> memory_step;
  std::vector<std::string> object_names;  // of the scene's props
  std::vector<std::string> paraphrases;   // of the episode's instruction
};

// Names of the arrays that tell what a policy may not see; the others.
std::vector<std::string> privileged_labels(const TaskInfo& info);
inline std::vector<std::string> open_labels() { return {"paraphrases"}; }

// Writes down the labels of one environment's episode. The batch observes colours, depth and
// segmentation of both cameras.
class LabelRecorder {
 public:
  // After the environment's reset. Throws Error if the task has no words for its episodes.
  void start(const Batch& batch, int index);
  void before_step(const Batch& batch, int index);
  void after_step(const Batch& batch, int index);

  const EpisodeLabels& labels() const { return labels_; }

 private:
  void note_words(const Batch& batch, int index);
  void note_object(const Batch& batch, int index, int prop);

  EpisodeLabels labels_;
  bool answers_ = false;               // the task asks for an answer
  std::vector<std::int16_t> segment_;  // of each prop, -1: none
  std::vector<std::string> plan_;      // as of the last frame
};

// Labels as arrays of a file. The labels outlive this object.
class LabelArrays {
 public:
  explicit LabelArrays(const EpisodeLabels& labels);
  explicit LabelArrays(EpisodeLabels&& labels) = delete;
  LabelArrays(const LabelArrays&) = delete;
  LabelArrays& operator=(const LabelArrays&) = delete;

  const std::vector<NpyArray>& arrays() const { return arrays_; }

 private:
  void add_texts(const char* name, const std::vector<std::string>& texts);

  std::vector<std::u32string> storage_;  // of texts
  std::vector<NpyArray> arrays_;
};

}  // namespace engram
