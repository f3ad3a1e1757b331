// Names of enum values, which count from 0: names_of(Enum) has a name for each.
#pragma once

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <optional>
#include <string>
#include <string_view>

#include "core/base/error.h"
#include "core/base/join.h"

namespace engram {

template <class Enum>
constexpr const char* name_of(Enum value) {
  return names_of(Enum())[static_cast<std::size_t>(value)];
}

// Returns nullopt for an unknown name.
template <class Enum>
std::optional<Enum> find_named(std::string_view name) {
  const auto& names = names_of(Enum());
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end()) return std::nullopt;
  return static_cast<Enum>(found - names.begin());
}

// Throws Error (kUnknownId), with all names, for an unknown one. what: "control mode".
template <class Enum>
Enum require_named(const char* what, std::string_view name) {
  if (const std::optional<Enum> found = find_named<Enum>(name)) return *found;
  throw Error(Error::kUnknownId, std::string("no ") + what + " named '" + std::string(name) +
                                     "'; allowed are: " + join(names_of(Enum())));
}

}  // namespace engram
