// Python programs of child processes, in the Python that is installed.
#include "core/base/python_program.h"

#include <catch2/catch.hpp>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include "tests/temporary_folder.h"

namespace engram::test {
namespace {

// The exit code of the program in a folder with a module `json` of its own, which writes a file.
int run_beside_planted_module(const std::filesystem::path& folder, const std::string& program) {
  std::ofstream(folder / "json.py") << "open('ran', 'w').close()\n";
  const std::string line = "cd '" + folder.string() + "' && python3 -c \"" + program + "\"";
  return std::system(line.c_str());
}

}  // namespace

TEST_CASE("python_program: nothing is imported from the current folder", "[base]") {
  const TemporaryFolder folder;
  const std::string body = "import json\nsys.exit(0 if hasattr(json, 'loads') else 3)\n";
  CHECK(run_beside_planted_module(folder.path(), python_program(body)) == 0);
  CHECK_FALSE(std::filesystem::exists(folder.path() / "ran"));
  // The module would have been imported without it.
  CHECK(run_beside_planted_module(folder.path(), "import sys\n" + body) != 0);
  CHECK(std::filesystem::exists(folder.path() / "ran"));
}

}  // namespace engram::test
