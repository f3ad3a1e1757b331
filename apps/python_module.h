// Subcommands and processes that are modules of the Python package.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace engram::apps {

// The words that run a module's function `run`: the Python that ENGRAM_PYTHON names, or python3,
// and its arguments. what: the subcommand or option that needs it, for the message of a Python
// without the package.
std::vector<std::string> python_words(std::string_view module, std::string_view what);

// Replaces this process by the program. Throws Error (kUnavailable) if it cannot be started.
[[noreturn]] void become(std::vector<std::string> words, std::string_view what);

// The words as a command for /bin/sh, which becomes the program.
std::string shell_command(const std::vector<std::string>& words);

}  // namespace engram::apps
