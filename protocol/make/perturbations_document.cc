#include "protocol/make/perturbations_document.h"

#include <algorithm>
#include <vector>

namespace engram {

Json perturbations_document(std::span<const PerturbationLevel> levels) {
  std::vector<PerturbationLevel> used;
  std::ranges::copy_if(levels, std::back_inserter(used),
                       [](const auto& one) { return one.level > 0; });
  std::ranges::sort(used, {}, &PerturbationLevel::axis);
  JsonTable table;
  for (const PerturbationLevel& one : used) table.emplace_back(name_of(one.axis), one.level);
  return table.empty() ? Json() : Json(table);
}

}  // namespace engram
