// Outputs of a group of batches: arrays over the environments of all of them, one behind the other.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/base/aligned_array.h"
#include "core/batch/output_array.h"
#include "core/batch/output_copies.h"
#include "core/batch/row_layout.h"

namespace engram {

// A batch of a group, and where its environments begin.
struct GroupPart {
  Batch* batch = nullptr;
  int first = 0;
};

// With common arrays, each output of any batch has one: as wide as the widest of that name, zero
// where a task lacks it; float32 where types differ; privileged where it is so in one task.
// task_cue is the cue that policies may see, if a task has one. Observation rows have a RowLayout.
// Two more outputs are task_index and, in the objects modes, object_mask.
class GroupOutputs {
 public:
  // common: false for a single batch whose own arrays are the group's. The batches outlive this
  // object.
  GroupOutputs(const std::vector<GroupPart>& parts, bool common);

  const std::vector<OutputArray>& arrays() const { return arrays_; }
  const std::vector<OutputArray>& finals() const { return finals_; }
  const std::vector<RangedField>& row_fields() const { return layout_.fields(); }
  // True if that part's task has the output.
  bool has(std::size_t part, std::string_view name) const;

  // Adds the copies of a part that the common arrays need; none without common arrays.
  void add_copies(std::size_t part, OutputCopies& copies) const;
  // Adds those of one output into another array of its shape.
  void add_copies_into(std::size_t part, const OutputArray& array, std::byte* to,
                       OutputCopies& copies) const;
  // Points an array to other memory.
  void redirect(std::size_t index, std::byte* data) { arrays_[index].data = data; }
  // Rows of a part's images in arrays like `arrays`.
  ImageTargets images_in(std::size_t part, const std::vector<OutputArray>& arrays) const;

 private:
  struct Source {
    std::vector<OutputArray> now;
    std::vector<OutputArray> finals;
    std::vector<RangedField> row;
  };

  std::vector<OutputArray> merged(std::vector<OutputArray> Source::*list) const;
  bool shares(std::size_t part, std::string_view name) const;
  void add_constants();
  void allocate(std::vector<OutputArray>& arrays);
  void add(std::size_t part, const OutputArray& from, const OutputArray& array, std::byte* to,
           void (OutputCopies::*add_copy)(const RowCopy&), OutputCopies& copies) const;

  std::vector<GroupPart> parts_;
  int num_envs_ = 0;
  bool common_;
  bool any_cue_ = false;         // a task has a cue that policies may see
  std::vector<Source> sources_;  // one for each part
  RowLayout layout_;
  std::vector<OutputArray> arrays_;
  std::vector<OutputArray> finals_;
  std::vector<AlignedArray<std::byte>> memory_;
};

}  // namespace engram
