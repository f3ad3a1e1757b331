// Programs for `python -c`, of which every child process in Python is started.
#pragma once

#include <string>
#include <string_view>

namespace engram {

// A program that imports nothing from the current folder, which `python -c` and `python -m` put
// first. The option -P does the same from Python 3.11 on; 3.10 lacks it, and child processes of
// this one keep the current folder, as their commands expect.
inline std::string python_program(std::string_view body) {
  return "import sys\n"
         "sys.path[:] = [path for path in sys.path if path]\n" +
         std::string(body);
}

}  // namespace engram
