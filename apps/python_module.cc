#include "apps/python_module.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>

#include "core/base/error.h"
#include "core/base/python_program.h"

namespace engram::apps {
namespace {

constexpr const char* kProgram =
    "try:\n"
    "    from {0}.__main__ import run\n"
    "except ModuleNotFoundError as error:\n"
    "    if error.name not in ('engram', '{0}', '{0}.__main__'):\n"
    "        raise\n"
    "    print('engram: {1} needs the Python package of this project, as a wheel: ' +\n"
    "          sys.executable + ' has none', file=sys.stderr)\n"
    "    sys.exit(1)\n"
    "run()\n";

}  // namespace

std::vector<std::string> python_words(std::string_view module, std::string_view what) {
  const char* given = std::getenv("ENGRAM_PYTHON");
  return {given != nullptr ? given : "python3", "-c",
          python_program(fmt::format(fmt::runtime(kProgram), module, what))};
}

void become(std::vector<std::string> words, std::string_view what) {
  std::vector<char*> arguments;
  arguments.reserve(words.size() + 1);
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  ::execvp(arguments[0], arguments.data());
  throw Error(Error::kUnavailable, fmt::format("{} needs Python: '{}' cannot be started: {}", what,
                                               words[0], std::strerror(errno)));
}

std::string shell_command(const std::vector<std::string>& words) {
  std::string command = "exec";
  for (const std::string& word : words) {
    command += " '";
    for (const char c : word) {
      if (c == '\'') {
        command += "'\\''";
      } else {
        command += c;
      }
    }
    command += '\'';
  }
  return command;
}

}  // namespace engram::apps
