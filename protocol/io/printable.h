// Escaping of foreign text for display: names, messages, commands.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace engram {

// The first character of a text, or its first byte if no character of UTF-8 begins there.
struct Letter {
  std::size_t length = 1;  // bytes
  char32_t code = 0;       // the byte, if it is not valid
  bool valid = false;

  // False for bytes without meaning, controls of terminals, line separators, and marks that reverse
  // the order of what follows.
  bool printable() const;
};

// The text must not be empty.
Letter first_letter(std::string_view text);

// The text in UTF-8 without anything that moves the cursor of a terminal, changes its title or
// reverses the order of letters. Such characters are written as JSON writes them (\u001b, \u202e),
// and bytes that are not UTF-8 as \x9b. In several lines, line breaks and tabs stay.
std::string printable(std::string_view text, bool several_lines = false);

}  // namespace engram
