// One task of every family, for what is checked or measured family by family.
#pragma once

#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

#include "tasks/registry.h"

namespace engram {

// The id of the first task of every family, in the benchmark's order.
inline std::vector<std::string> one_of_each_family() {
  std::vector<std::string> ids;
  std::vector<std::string_view> families;
  for (const RegistryEntry& entry : registry()) {
    if (std::find(families.begin(), families.end(), entry.family) != families.end()) continue;
    families.push_back(entry.family);
    ids.emplace_back(entry.id);
  }
  return ids;
}

// The ids of short episodes, for tests that cannot play all.
inline std::vector<std::string> short_ids() {
  constexpr int kLongest = 200;  // steps
  std::vector<std::string> ids;
  for (const RegistryEntry& entry : registry()) {
    if (entry.horizon <= kLongest) ids.emplace_back(entry.id);
  }
  return ids;
}

}  // namespace engram
