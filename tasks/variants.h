// Users' own ids, as the registry keeps them.
#pragma once

#include <string_view>

#include "tasks/registry.h"

namespace engram {

// The variant of that exact id, or nullptr.
const RegistryEntry* find_variant_entry(std::string_view id) noexcept;

// Constants in order, those of `changes` instead of others of the same name.
ConstantTable overridden(const ConstantTable& constants, const ConstantTable& changes);

}  // namespace engram
