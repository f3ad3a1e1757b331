// Escaping of foreign text for display: names, messages, commands.
#pragma once

#include <string>
#include <string_view>

namespace engram {

// The text with every control character written as JSON writes it (\u001b), so that it cannot move
// the cursor of a terminal or change its title. In several lines, line breaks and tabs stay. Other
// bytes, those of UTF-8 too, are as they were.
std::string printable(std::string_view text, bool several_lines = false);

}  // namespace engram
