// Names that users may have meant.
#pragma once

#include <algorithm>
#include <cstddef>
#include <functional>
#include <ranges>
#include <string>
#include <string_view>

namespace engram {

// Number of characters to insert, delete or replace to turn `a` into `b`, upper and lower case
// being alike.
std::size_t edit_distance(std::string_view a, std::string_view b);

// The name, out of those of all items, with the fewest edits from `given`; the first of several, ""
// where there is none. name: gives an item's name; a member or a function.
template <class Items, class Name = std::identity>
std::string nearest(const Items& items, std::string_view given, Name name = {}) {
  // No name is nearly this long: what follows tells nothing and would only cost time.
  given = given.substr(0, 100);
  const auto distance = [&](const auto& item) {
    return edit_distance(given, std::string_view(std::invoke(name, item)));
  };
  const auto found = std::ranges::min_element(items, {}, distance);
  return found == std::ranges::end(items) ? "" : std::string(std::invoke(name, *found));
}

}  // namespace engram
