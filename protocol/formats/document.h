// Documents as the data of JSON. Unlike the JSON library's own, whose destructors allocate and
// whose constructors leak, they live through running out of memory.
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

// The document that a text is. Nothing if it is none, or nests deeper than any that engram writes:
// programs that walk through documents call themselves at every level.
std::optional<Document> parse_document(std::string_view text);

// As JSON: two-space indentation, newline at the end. What is not UTF-8 becomes U+FFFD; numbers
// that JSON does not have (infinite, undefined) become null.
std::string to_text(const Document& document);
// The same without line breaks and spaces.
std::string to_line(const Document& document);

// The part of a table; null if there is none of that name, or it is no table.
const Document* find(const Document& document, std::string_view key);
// The same; throws Error (kIo) if there is none.
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
