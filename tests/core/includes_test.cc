// Imports point downwards only: read from the sources themselves.
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <string>

#include "tests/build_paths.h"

namespace engram {
namespace {

namespace fs = std::filesystem;

const fs::path kRoot = test::kRoot;

// What each room may include of the others. "engram" are the public headers in api/.
const std::map<std::string, std::set<std::string>> kMayInclude = {
    {"core", {"core"}},
    {"mjcf", {"mjcf"}},
    {"tasks", {"core", "mjcf", "tasks"}},
    {"render", {"core", "render"}},
    {"media", {"core", "media"}},
    {"protocol", {"core", "mjcf", "tasks", "render", "media", "protocol"}},
    {"api", {"core", "mjcf", "tasks", "render", "media", "protocol", "api", "engram"}},
    {"apps", {"protocol", "api", "engram", "bench", "apps"}},
};

std::set<std::string> rooms() {
  std::set<std::string> names = {"engram"};
  for (const auto& entry : fs::directory_iterator(kRoot)) {
    if (entry.is_directory()) names.insert(entry.path().filename().string());
  }
  return names;
}

TEST_CASE("Every room includes only the rooms below it", "[includes]") {
  const std::regex include(R"re(^\s*#\s*include\s*["<]([^/">]+)/[^">]*[">])re");
  const std::set<std::string> all_rooms = rooms();
  int includes = 0;
  for (const auto& [room, allowed] : kMayInclude) {
    if (!fs::exists(kRoot / room)) continue;
    for (const auto& entry : fs::recursive_directory_iterator(kRoot / room)) {
      const std::string extension = entry.path().extension().string();
      if (extension != ".h" && extension != ".cc") continue;
      std::ifstream file(entry.path());
      std::smatch match;
      for (std::string line; std::getline(file, line);) {
        if (!std::regex_search(line, match, include)) continue;
        const std::string other = match[1];
        if (!all_rooms.contains(other)) continue;  // a library
        ++includes;
        INFO(entry.path().string() << ": " << line);
        CHECK(allowed.contains(other));
      }
    }
  }
  CHECK(includes > 20);
}

}  // namespace
}  // namespace engram
