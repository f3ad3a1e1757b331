// Values of documents: those whose keys may be missing, and lists.
#pragma once

#include <string_view>

#include "protocol/io/document.h"

namespace engram {

// The value under a key; null if there is none.
inline Document value_or_null(const Document& document, std::string_view key) {
  const Document* value = find(document, key);
  return value == nullptr ? Document() : *value;
}

// The values of a range as a list.
template <class Range>
DocumentList to_list(const Range& values) {
  return DocumentList(values.begin(), values.end());
}

}  // namespace engram
