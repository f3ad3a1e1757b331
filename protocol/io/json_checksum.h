// Checksums at the end of documents. They reveal damage and edits by hand.
#pragma once

#include <string>

#include "protocol/io/json.h"

namespace engram {

// Checksum of a document: 16 digits of the SHA-256 of its line.
std::string document_checksum(const JsonTable& document);
// Appends it under the key "checksum".
void add_checksum(JsonTable& document);
// True if the document ends with the checksum of the rest.
bool has_valid_checksum(const Json& document);

}  // namespace engram
