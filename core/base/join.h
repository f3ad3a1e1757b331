// Texts in a row, as messages list the names that are allowed.
#pragma once

#include <functional>
#include <string>
#include <string_view>

namespace engram {

// The texts of all items, separated. text: gives an item's text; a member or a function.
template <class Items, class Text = std::identity>
std::string join(const Items& items, Text&& text = {}, std::string_view separator = ", ") {
  std::string joined;
  bool first = true;
  for (const auto& item : items) {
    if (!first) joined += separator;
    joined += std::invoke(text, item);
    first = false;
  }
  return joined;
}

}  // namespace engram
