// Documents of the JSON library, for what the commands print: keys stay in the order in which they
// are set.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "protocol/formats/document.h"

namespace engram::apps {

using Json = nlohmann::ordered_json;

// A number, or null where JSON has none for it (infinite, undefined).
Json to_json(double value);
Json to_json(const Document& document);
Json to_json(const DocumentTable& table);

// The document as text: two-space indentation, newline at the end. What is not UTF-8 becomes
// U+FFFD.
std::string to_text(const Json& document);

}  // namespace engram::apps
