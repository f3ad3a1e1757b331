// Values of documents: those whose keys may be missing, and lists.
#pragma once

#include <string_view>

#include "protocol/io/json.h"

namespace engram {

// The value under a key; null if there is none.
inline Json value_or_null(const Json& document, std::string_view key) {
  const Json* value = find(document, key);
  return value == nullptr ? Json() : *value;
}

// The values of a range as a list.
template <class Range>
JsonList to_list(const Range& values) {
  return JsonList(values.begin(), values.end());
}

}  // namespace engram
