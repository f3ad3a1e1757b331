// One layout of observation rows for several tasks: a field of one name has one place in the rows
// of all of them.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "core/batch/batch.h"
#include "core/observe/object_tokens.h"

namespace engram {

// Fields of a batch's observation rows; those of states have no ranges.
std::vector<RangedField> row_fields(const Batch& batch);

// Objects in such rows; none in rows of states.
int count_tokens(std::span<const RangedField> fields);

class RowLayout {
 public:
  // parts: fields of each part's rows. Fields keep their order; one that parts have in different
  // widths has the greatest.
  explicit RowLayout(const std::vector<std::vector<RangedField>>& parts);

  const std::vector<RangedField>& fields() const { return fields_; }
  int width() const { return width_; }
  // Offset of a field in the common rows.
  int offset_of(const std::string& name) const;

 private:
  std::vector<RangedField> fields_;
  std::vector<int> offsets_;
  int width_ = 0;
};

}  // namespace engram
