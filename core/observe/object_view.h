// Observations of the objects modes: the robot and the tokens of a batch, and those of the episodes
// that ended last. They are no columns: they follow from the columns.
#pragma once

#include <span>
#include <vector>

#include "core/base/aligned_array.h"
#include "core/base/index.h"
#include "core/observe/object_tokens.h"
#include "core/task/task.h"

namespace engram {

struct ObjectViewOptions {
  int num_envs = 0;
  bool time = false;         // elapsed time is observed
  bool keeps_final = false;  // observations of ended episodes are kept
};

class ObjectView {
 public:
  // tokens: already bound, and of the same task.
  ObjectView(const TaskInfo& info, const ObjectTokens& tokens, const ObjectViewOptions& options);

  // The parts of a row, in order, with units.
  const std::vector<Field>& fields() const { return fields_; }
  // The parts with their ranges.
  const std::vector<RangedField>& ranged_fields() const { return ranged_fields_; }
  int width() const { return row_.width; }
  // Bytes that every further environment adds.
  std::size_t bytes() const {
    const std::size_t rows = options_.keeps_final ? 2 : 1;
    return rows * sizeof(float) * at(row_.width);
  }
  ColumnView rows() { return {&row_, reinterpret_cast<std::byte*>(rows_.data())}; }
  ColumnView final_rows() { return {&row_, reinterpret_cast<std::byte*>(final_rows_.data())}; }
  std::span<const float> all() const { return rows_.span(); }
  // The part before the tokens. Those are numbers, because physics ends episodes with other poses.
  std::span<const float> robot_part(int env) const {
    const auto width = at(row_.width);
    return rows_.span().subspan(at(env) * width, width - at(tokens_.width()));
  }

  // key: of the episode's random streams. task_cue: of the environment, where there is one.
  void write(const State& state, int env, std::uint64_t key, const float* task_cue);
  void keep_final(int env);

 private:
  float* row(AlignedArray<float>& rows, int env) const {
    return rows.data() + static_cast<std::ptrdiff_t>(env) * row_.width;
  }

  const ObjectTokens& tokens_;
  ObjectViewOptions options_;
  int task_cue_dim_;
  float per_step_;  // of time: 1 / horizon
  std::vector<Field> fields_;
  Field row_;
  AlignedArray<float> rows_;
  AlignedArray<float> final_rows_;
  std::vector<RangedField> ranged_fields_;
};

}  // namespace engram
