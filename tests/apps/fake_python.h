// A program that stands for Python, for commands that start it.
#pragma once

#include <filesystem>
#include <fstream>
#include <string>

#include "tests/temporary_folder.h"

namespace engram::test {

// The variable that names a shell script as Python.
inline std::string fake_python(const TemporaryFolder& folder, const std::string& script) {
  const std::filesystem::path path = folder.path() / "python";
  std::ofstream(path) << "#!/bin/sh\n" << script << '\n';
  std::filesystem::permissions(path, std::filesystem::perms::owner_all);
  return "ENGRAM_PYTHON='" + path.string() + "'";
}

// Prints the arguments, one a line, without -c and the program.
inline constexpr const char* kPrintArguments = "shift 2; printf '%s\\n' \"$@\"";

}  // namespace engram::test
