// Hidden test cases of this program, run in processes of their own.
#pragma once

#include <catch2/catch.hpp>
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

namespace engram::test {

// The lines that the test cases of that tag print, and what Catch says. `environment` sets
// variables.
inline std::vector<std::string> lines_of_own_process(const std::string& tag,
                                                     const std::string& environment) {
  const std::string program = std::filesystem::read_symlink("/proc/self/exe").string();
  const std::string command = environment + " '" + program + "' '[" + tag + "]'";
  FILE* pipe = popen(command.c_str(), "r");
  REQUIRE(pipe != nullptr);
  std::vector<std::string> lines;
  char line[1000];
  while (std::fgets(line, sizeof line, pipe) != nullptr) lines.emplace_back(line);
  CHECK(pclose(pipe) == 0);
  return lines;
}

}  // namespace engram::test
