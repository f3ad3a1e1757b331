// Experts alone act upon privileged state, and their path shows it.
#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <regex>
#include <string>
#include <vector>

#include "tests/conventions/sources.h"

namespace engram {
namespace {

namespace fs = std::filesystem;

// Headers with which actions are made.
const std::vector<std::string> kServos = {
    "tasks/common/tcp_servo.h", "tasks/common/grasp_servo.h",  "tasks/common/press_servo.h",
    "tasks/common/tour.h",      "tasks/common/guess_stream.h", "tasks/custom/array_functions.h"};

bool is_expert(const fs::path& file) { return file.stem().string().ends_with("expert"); }

bool is_servo(const fs::path& file) {
  const std::string header = fs::path(file).replace_extension(".h").string();
  return std::find(kServos.begin(), kServos.end(), header) != kServos.end();
}

std::vector<std::string> includes_of(const fs::path& file) {
  static const std::regex include(R"re(^\s*#\s*include\s*"([^"]+)")re");
  std::vector<std::string> names;
  for (const std::string& line : test::lines_of(test::kRoot / file)) {
    std::smatch match;
    if (std::regex_search(line, match, include)) names.push_back(match[1]);
  }
  return names;
}

TEST_CASE("Only experts include what makes actions", "[conventions]") {
  int experts = 0;
  for (const fs::path& file : test::files_in("tasks", {".h", ".cc"})) {
    if (is_expert(file)) ++experts;
    if (is_expert(file) || is_servo(file)) continue;
    INFO(file.string());
    for (const std::string& name : includes_of(file)) {
      INFO("includes " << name);
      CHECK_FALSE(is_servo(name));
      CHECK(name != "core/task/expert.h");
    }
  }
  CHECK(experts > 20);
}

TEST_CASE("An expert is known to its own family alone", "[conventions]") {
  int includes = 0;
  for (const char* folder :
       {"core", "mjcf", "tasks", "render", "media", "protocol", "api", "apps"}) {
    for (const fs::path& file : test::files_in(folder, {".h", ".cc"})) {
      for (const std::string& name : includes_of(file)) {
        const fs::path header = name;
        if (!is_expert(header) || header.parent_path() == "core/task") continue;
        INFO(file.string() << " includes " << name);
        CHECK(header.parent_path() == file.parent_path());
        ++includes;
      }
    }
  }
  CHECK(includes > 20);
}

TEST_CASE("Every family of tasks has an expert", "[conventions]") {
  for (const auto& entry : fs::directory_iterator(test::kRoot / fs::path("tasks"))) {
    const std::string family = entry.path().filename().string();
    if (!entry.is_directory() || family == "common" || family == "custom") continue;
    INFO(family);
    CHECK(fs::exists(entry.path() / "expert.cc"));
  }
}

}  // namespace
}  // namespace engram
