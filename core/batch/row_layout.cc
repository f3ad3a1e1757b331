#include "core/batch/row_layout.h"

#include <algorithm>

#include "core/base/error.h"
#include "core/batch/queries.h"

namespace engram {
namespace {

auto find_field(std::vector<RangedField>& fields, const std::string& name) {
  return std::ranges::find_if(
      fields, [&name](const RangedField& field) { return field.field.name == name; });
}

}  // namespace

std::vector<RangedField> row_fields(const Batch& batch) {
  const std::span<const RangedField> ranged = Queries(batch).ranged_fields();
  if (!ranged.empty()) return {ranged.begin(), ranged.end()};
  std::vector<RangedField> fields;
  if (batch.observation().empty()) return fields;
  for (const Field& field : batch.state_fields()) fields.emplace_back().field = field;
  return fields;
}

int count_tokens(std::span<const RangedField> fields) {
  return static_cast<int>(std::ranges::count_if(fields, [](const RangedField& field) {
    return field.field.name.starts_with("object_") && field.field.name.ends_with("_seen");
  }));
}

RowLayout::RowLayout(const std::vector<std::vector<RangedField>>& parts) {
  for (const std::vector<RangedField>& part : parts) {
    auto next = fields_.begin();  // where this part's next field goes, if it is new
    for (const RangedField& field : part) {
      auto found = find_field(fields_, field.field.name);
      if (found == fields_.end()) {
        found = fields_.insert(next, field);
      } else {
        found->field.width = std::max(found->field.width, field.field.width);
        if (found->field.description != field.field.description) found->field.description.clear();
      }
      next = found + 1;
    }
  }
  for (const RangedField& field : fields_) {
    offsets_.push_back(width_);
    width_ += field.field.width;
  }
}

int RowLayout::offset_of(const std::string& name) const {
  for (std::size_t i = 0; i < fields_.size(); ++i) {
    if (fields_[i].field.name == name) return offsets_[i];
  }
  throw Error(Error::kInternal, "no field '" + name + "' in the common rows");
}

}  // namespace engram
