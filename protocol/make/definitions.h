// Definitions of custom tasks by content, and the comparison of two of them.
#pragma once

#include <string>
#include <vector>

#include "protocol/io/json.h"
#include "tasks/registry.h"

namespace engram {

// The SHA-256 of the definition of a custom task, or of the task that a variant changes; null for
// built-in tasks.
Json definition_of(const RegistryEntry& entry);

// {id: definition} of the custom tasks among these.
JsonTable definitions_of(const std::vector<std::string>& ids);

// Throws Error (kInvalidArgument) with the id and both hashes' beginnings if the definitions, each
// a hash or null, differ. there: has the first of them; here: has the other.
void require_same_definition(const std::string& id, const Json& first, const std::string& there,
                             const Json& other, const std::string& here = "this process");

// Throws such an Error unless this process defines these tasks as a table of definitions says.
void require_definitions(const std::vector<std::string>& ids, const Json& table,
                         const std::string& there);

}  // namespace engram
