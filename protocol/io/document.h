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

using Document = Constant;
using DocumentList = ConstantList;
using DocumentTable = ConstantTable;

// Reads a text. Nothing if it is not JSON, or is nested deeper than engram's own documents:
// functions that traverse them are recursive.
std::optional<Document> parse_document(std::string_view text);

// JSON text: two-space indentation, newline at the end. Malformed UTF-8 becomes U+FFFD; numbers
// that JSON does not have (infinite, undefined) become null.
std::string to_text(const Document& document);
// The same without line breaks and spaces.
std::string to_line(const Document& document);

// The value under a key of a table; null if the key is missing or the document is not a table.
const Document* find(const Document& document, std::string_view key);
// The same, but throws Error (kIo) instead.
const Document& part(const Document& document, std::string_view key);

bool is_null(const Document& document);
bool is_table(const Document& document);
bool is_number(const Document& document);

// The content. Throw Error (kIo) if it is of another type.
bool truth(const Document& document);
double number(const Document& document);
// Without a fraction, and not negative.
std::uint64_t whole_number(const Document& document, std::uint64_t most = UINT64_MAX);
const std::string& text(const Document& document);
const DocumentList& list(const Document& document);
const DocumentTable& table(const Document& document);

}  // namespace engram
