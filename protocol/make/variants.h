// Users' own ids as JSON (docs/variants.md): in files, in results and in data sets.
#pragma once

#include <filesystem>
#include <string_view>

#include "protocol/io/json.h"
#include "tasks/registry.h"

namespace engram {

// A table of constants out of a JSON text, {"COLORS": 7, "CUE_PHASE_STEPS": [30, 50]}. Throws Error
// (kInvalidArgument) if it is anything else.
ConstantTable parse_constants(std::string_view json);

// One variant: id, base, constants, and instruction where it has its own.
Json to_document(const TaskVariant& variant);
// Throws Error (kInvalidArgument) if a key is missing, unknown or of the wrong type. what: the name
// of the whole document, for the message.
TaskVariant to_variant(const Json& document, std::string_view what);

// Registers all variants of a file, {"variants": [variant, ...]}, or none. Throws Error: kIo if
// it cannot be read, kInvalidArgument or kUnknownId, naming the file, if it is not such a file or a
// variant is refused.
void load_variants(const std::filesystem::path& file);

// The variant that results are of: base and constants; null for one of the benchmark's tasks with
// its own constants. constants: those given by argument.
Json variant_document(const RegistryEntry& entry, const ConstantTable& constants);

}  // namespace engram
