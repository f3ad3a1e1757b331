// JSON documents: keys stay in the order in which they are set.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "core/constant.h"

namespace engram {

using Json = nlohmann::ordered_json;

// A number, or null where JSON has none for it (infinite, undefined).
Json to_json(double value);
// Truths, numbers, texts, arrays and objects.
Json to_json(const Constant& constant);
Json to_json(const ConstantTable& table);

// The document that a text is; a discarded value if it is none, or nests deeper than any that
// engram writes: programs that walk through documents call themselves at every level.
Json parse_json(std::string_view text);

// The document as text: two-space indentation, newline at the end. What is not UTF-8 becomes
// U+FFFD.
std::string to_text(const Json& document);
// The same of constants. Unlike Json, whose destructor allocates, this lives through running out of
// memory.
std::string to_text(const Constant& document);

}  // namespace engram
