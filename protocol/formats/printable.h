// Escaping of foreign text for display: names, messages, commands.
#pragma once

#include <string>
#include <string_view>

namespace engram {

// The text in UTF-8 without anything that moves the cursor of a terminal, changes its title or
// reverses the order of letters. Such characters are written as JSON writes them (\u001b, \u202e),
// and bytes that are not UTF-8 as \x9b. In several lines, line breaks and tabs stay.
std::string printable(std::string_view text, bool several_lines = false);

}  // namespace engram
