// Outputs of a batch as arrays over its environments: a task's own, or common ones of several
// tasks; and arrays of callers that they are written to.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/base/aligned_array.h"
#include "core/batch/batch_data.h"
#include "core/batch/output_copies.h"

namespace engram {

// One output of all environments: a column, the observation, or images.
struct OutputArray {
  Field field;                      // its width: elements of one environment
  std::vector<std::int64_t> shape;  // num_envs first; without a second one where the width is 1
  std::byte* data = nullptr;

  std::size_t row_bytes() const { return at(field.width) * size_of(field.dtype); }
};

// The array of that name; null if there is none.
const OutputArray* find_array(const std::vector<OutputArray>& arrays, std::string_view name);

// A caller's array that an output is written to.
struct OutputTarget {
  std::string name;
  void* data = nullptr;
  std::size_t bytes = 0;
};

// With common arrays, each output of any task has one: as wide as the widest of that name, zero
// where a task lacks it; float32 where types differ; privileged where it is so in one task.
// task_cue is the cue that policies may see, if a task has one. A field of one name has one place
// in the observation rows of all tasks. Two more outputs are task_index and, in the objects modes,
// object_mask.
class BatchOutputs {
 public:
  // parts: tasks whose environments follow one another; they outlive this object. common: false for
  // a single task whose own arrays are the outputs.
  BatchOutputs(std::span<BatchData* const> parts, bool common);

  // Outputs in the order of users' lists: columns, final_mask, images.
  const std::vector<OutputArray>& now() const { return now_; }
  // At the end of each environment's last episode; empty unless the batch keeps them.
  const std::vector<OutputArray>& finals() const { return finals_; }
  // Fields of the observation's row; those of states have no ranges.
  const std::vector<RangedField>& row_fields() const { return row_; }
  // True if that part's task has the output.
  bool has(std::size_t part, std::string_view name) const;

  // See Batch::write_to.
  void write_to(std::span<const std::vector<OutputTarget>> turns);
  // The turn whose arrays the last step or reset has written to.
  int buffer() const { return static_cast<int>(buffer_); }
  // The next step writes to the arrays of the next turn, where there are several.
  void next_buffer();

 private:
  struct Part {
    BatchData* data = nullptr;
    std::vector<OutputArray> now;
    std::vector<OutputArray> finals;
    std::vector<RangedField> row;
    // One of each turn.
    std::vector<OutputCopies> copies;
    std::vector<ImageTargets> images;
  };

  std::vector<OutputArray> merged(std::vector<OutputArray> Part::*list) const;
  void add_constants();
  void fill_constants(const Part& part, int index) const;
  void allocate(std::vector<OutputArray>& arrays);
  void add_common_copies(Part& part, OutputCopies& copies) const;
  void add_copies(const Part& part, const std::vector<OutputArray>& own, const OutputArray& to,
                  void (OutputCopies::*add)(const RowCopy&), OutputCopies& copies) const;
  bool hides_cue(const Part& part, std::string_view name) const;
  static ImageTargets images_in(const Part& part, const std::vector<OutputArray>& arrays);
  void check(std::span<const OutputTarget> targets) const;
  void set_turns(std::size_t count);
  void add_targets(std::span<const OutputTarget> targets, std::size_t turn);
  void use_buffer();

  std::vector<Part> parts_;
  int num_envs_ = 0;
  bool common_;
  bool any_cue_ = false;  // a task has a cue that policies may see
  std::vector<RangedField> row_;
  std::vector<OutputArray> now_;
  std::vector<OutputArray> finals_;
  std::vector<AlignedArray<std::byte>> memory_;
  // Callers' arrays of images by the number of the output, of each turn.
  std::vector<std::vector<std::pair<std::size_t, std::byte*>>> user_images_;
  std::size_t buffer_ = 0;
};

// One row for several tasks: fields keep their order, and one that tasks have in different widths
// has the greatest.
std::vector<RangedField> merged_rows(std::span<const std::vector<RangedField>> rows);
// Elements of such a row, and elements before a field. Throws Error for an unknown name.
int row_width(std::span<const RangedField> fields);
int offset_of(std::string_view name, std::span<const RangedField> fields);
// Objects in such a row; none in rows of states.
int count_tokens(std::span<const RangedField> fields);

}  // namespace engram
