// Suggestions for misspelt names, by edit distance (Levenshtein, case-insensitive).
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

// Name with the fewest edits from `given` among all items; the first of several, "" if there are no
// items. name: returns an item's name; a member or a function.
template <class Items, class Name = std::identity>
std::string nearest(const Items& items, std::string_view given, Name name = {}) {
  // No name is nearly this long: the rest would only cost time.
  given = given.substr(0, 100);
  const auto distance = [&](const auto& item) {
    return edit_distance(given, std::string_view(std::invoke(name, item)));
  };
  const auto found = std::ranges::min_element(items, {}, distance);
  return found == std::ranges::end(items) ? "" : std::string(std::invoke(name, *found));
}

}  // namespace engram
