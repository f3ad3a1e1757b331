// The variants of a family, as tables.
#pragma once

#include <algorithm>
#include <iterator>
#include <memory>
#include <string>
#include <string_view>

#include "core/base/error.h"
#include "core/task/task.h"
#include "tasks/common/constant_binder.h"
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

// Declares the constants that every family has beside its own, and takes horizon and robot over.
void declare_common(ConstantBinder& constants, RegistryEntry& entry);

// Family::make of a class whose constructor takes the registry's entry and the row of a table. A
// row has
//   void declare(ConstantBinder& constants)    its constants (tasks/common/constant_binder.h)
//   void check(int horizon) const              throws Error unless a task can be made of it
template <class Made, const auto& kVariants>
std::unique_ptr<Task> make_variant(const RegistryEntry& entry, const ConstantTable& chosen) {
  auto params = find_variant(kVariants, entry.base);
  RegistryEntry own = entry;
  own.horizon = params.task.horizon;
  ConstantBinder constants(chosen);
  params.declare(constants);
  declare_common(constants, own);
  std::vector<TaskConstant> declared = constants.take();
  params.check(own.horizon);
  if (own.max_episode_steps > 0) own.horizon = own.max_episode_steps;
  auto task = std::make_unique<Made>(own, params);
  task->set_constants(std::move(declared));
  return task;
}

}  // namespace engram::tasks
