// Values of documents whose keys may be missing.
#pragma once

#include <string_view>

#include "protocol/formats/document.h"

namespace engram {

// The value under a key; null if there is none.
inline Document value_or_null(const Document& document, std::string_view key) {
  const Document* value = find(document, key);
  return value == nullptr ? Document() : *value;
}

}  // namespace engram
