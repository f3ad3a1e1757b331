// The variants of a family, as tables.
#pragma once

#include <algorithm>
#include <iterator>
#include <string>
#include <string_view>

#include "core/base/error.h"

namespace engram::tasks {

// The row of a family's table that belongs to an id. Throws Error if the table has none.
template <class Variants>
const auto& find_variant(const Variants& variants, std::string_view id) {
  const auto found = std::find_if(std::begin(variants), std::end(variants),
                                  [id](const auto& params) { return params.id == id; });
  if (found == std::end(variants)) {
    throw Error(Error::kInternal, "no variant for " + std::string(id));
  }
  return *found;
}

}  // namespace engram::tasks
