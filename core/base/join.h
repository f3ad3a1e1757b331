// Strings of numbers, and joined strings, for messages that list the allowed names.
#pragma once

#include <array>
#include <charconv>
#include <cmath>
#include <functional>
#include <string>
#include <string_view>

namespace engram {

// Joins the strings of all items. text: returns an item's string; a member or a function.
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

// The shortest decimal number that reads back as this one.
inline std::string shortest(double value) {
  constexpr double kWritten = 1e15;  // whole numbers up to here have no exponent
  if (std::abs(value) <= kWritten && std::trunc(value) == value) {
    return std::to_string(static_cast<long>(value));
  }
  std::array<char, 32> digits{};
  return {digits.data(), std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr};
}

}  // namespace engram
