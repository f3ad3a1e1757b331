// JSON documents. All JSON that the project writes comes from here. The JSON library's own
// documents are not used, because their destructors allocate and their constructors leak where
// memory runs out.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "core/base/constant.h"

namespace engram {

using Json = Constant;
using JsonList = ConstantList;
using JsonTable = ConstantTable;

// Reads a text. Nothing if it is not JSON, or is nested deeper than engram's own documents:
// functions that traverse them are recursive.
std::optional<Json> parse_json(std::string_view text);

// JSON text: two-space indentation, newline at the end. Malformed UTF-8 becomes U+FFFD; numbers
// that JSON does not have (infinite, undefined) become null.
std::string to_text(const Json& document);
// JSON text without line breaks and spaces.
std::string to_line(const Json& document);

// The value under a key of a table; null if the key is missing or the document is not a table.
const Json* find(const Json& document, std::string_view key);
// The value under a key of a table. Throws Error (kIo) if there is none.
const Json& part(const Json& document, std::string_view key);

bool is_null(const Json& document);
bool is_table(const Json& document);
bool is_number(const Json& document);

// The content. Throw Error (kIo) if it is of another type.
bool truth(const Json& document);
double number(const Json& document);
// Without a fraction, and not negative.
std::uint64_t whole_number(const Json& document, std::uint64_t most = UINT64_MAX);
const std::string& text(const Json& document);
const JsonList& list(const Json& document);
const JsonTable& table(const Json& document);

}  // namespace engram
