// The variants of a family, as tables.
#pragma once

#include <algorithm>
#include <iterator>
#include <memory>
#include <string>
#include <string_view>

#include "core/base/error.h"
#include "core/task.h"
#include "tasks/registry.h"

namespace engram::tasks {

// The row of a family's table that belongs to an id. Throws Error if the table has none.
template <class Variants>
const auto& find_variant(const Variants& variants, std::string_view id) {
  const auto found = std::find_if(std::begin(variants), std::end(variants),
                                  [id](const auto& params) { return params.task.id == id; });
  if (found == std::end(variants)) {
    throw Error(Error::kInternal, "no variant for " + std::string(id));
  }
  return *found;
}

// Family::make of a class whose constructor takes the registry's entry and the row of a table.
template <class Made, const auto& kVariants>
std::unique_ptr<Task> make_variant(const RegistryEntry& entry) {
  return std::make_unique<Made>(entry, find_variant(kVariants, entry.id));
}

// The same where the entry says everything.
template <class Made>
std::unique_ptr<Task> make_plain(const RegistryEntry& entry) {
  return std::make_unique<Made>(entry);
}

}  // namespace engram::tasks
