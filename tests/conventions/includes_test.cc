// The order of the rooms: includes point downwards only, and nowhere in a circle. Read from the
// sources themselves.
#include <algorithm>
#include <catch2/catch.hpp>
#include <map>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include "tests/conventions/sources.h"

namespace engram {
namespace {

namespace fs = std::filesystem;

// A room is a folder, or all folders in one ("tasks/*").
struct Room {
  std::string name;
  std::vector<std::string> below;  // what it may include
};

// From the ground up.
const std::vector<Room> kRooms = {
    {"core/base", {}},
    {"core/math", {"core/base"}},
    {"core/robot", {"core/base", "core/math"}},
    {"core/scene", {"core/base", "core/math", "core/robot"}},
    {"core/contact", {"core/base", "core/math", "core/robot", "core/scene"}},
    {"core/sim", {"core/base", "core/math", "core/robot", "core/scene", "core/contact"}},
    {"core/image", {"core/base", "core/math", "core/robot", "core/scene", "core/sim"}},
    {"core/env", {"core/*"}},
    {"mjcf", {"core/base", "core/math", "core/env"}},
    {"render/cpu", {"core/base", "core/math", "core/image"}},
    {"render/egl", {"core/base", "core/math", "core/image", "render/cpu"}},
    {"render", {"core/*", "render/cpu", "render/egl"}},
    {"media", {"core/base", "core/image"}},
    {"tasks", {"core/*"}},
    {"tasks/common", {"core/*", "mjcf", "tasks"}},
    {"tasks/*", {"core/*", "mjcf", "tasks", "tasks/common"}},
    {"tasks/registry.cc", {"core/*", "tasks", "tasks/*"}},
    {"protocol/formats", {"core/base"}},
    {"protocol/work", {"core/base", "protocol/formats"}},
    {"protocol/work/mpi", {"core/base", "protocol/work"}},
    {"protocol/batch", {"core/*", "tasks", "render", "protocol/formats", "protocol/work"}},
    {"protocol/evaluation",
     {"core/*", "media", "protocol/formats", "protocol/work", "protocol/batch"}},
    {"protocol/demonstrations",
     {"core/*", "media", "protocol/formats", "protocol/work", "protocol/batch"}},
    {"api/engram", {}},
    {"api", {"core/*", "render", "render/egl", "media", "protocol/*", "api/engram"}},
    {"bench", {"core/*", "tasks", "render", "render/cpu", "protocol/*"}},
    {"apps", {"protocol/*", "api", "bench"}},
    {"apps/examples", {"api/engram"}},
    {"python/src", {"api/engram"}},
};

// The one file that knows all families; its header lies below them.
constexpr const char* kRegistry = "tasks/registry.cc";

bool is_within(const std::string& room, const std::string& name) {
  if (!name.ends_with("/*")) return room == name;
  const std::string prefix = name.substr(0, name.size() - 1);
  return room.starts_with(prefix) && room != kRegistry;
}

// Nullptr for a folder that is no room.
const Room* find_room(const std::string& folder) {
  const auto named = [&](auto&& match) {
    const auto found = std::find_if(kRooms.begin(), kRooms.end(), match);
    return found == kRooms.end() ? nullptr : &*found;
  };
  const Room* exact = named([&](const Room& room) { return room.name == folder; });
  return exact != nullptr ? exact
                          : named([&](const Room& room) { return is_within(folder, room.name); });
}

bool may_include(const Room& room, const std::string& other) {
  return std::any_of(room.below.begin(), room.below.end(),
                     [&](const std::string& name) { return is_within(other, name); });
}

std::string folder_of(const std::string& file) {
  return file == kRegistry ? file : fs::path(file).parent_path().string();
}

using Graph = std::map<std::string, std::set<std::string>>;

// Every source file, and which of the others it includes.
Graph read_includes() {
  static const std::regex include(R"re(^\s*#\s*include\s*["<]([^">]+)[">])re");
  Graph graph;
  for (const char* folder :
       {"core", "mjcf", "tasks", "render", "media", "protocol", "api", "apps", "bench", "python"}) {
    for (const fs::path& file : test::files_in(folder, {".h", ".cc"})) graph[file.string()];
  }
  for (auto& [file, included] : graph) {
    for (const std::string& line : test::lines_of(test::kRoot / fs::path(file))) {
      std::smatch match;
      if (!std::regex_search(line, match, include)) continue;
      const std::string name = match[1];
      for (const std::string& path : {name, "api/" + name, folder_of(file) + "/" + name}) {
        if (graph.contains(path)) included.insert(path);
      }
    }
  }
  return graph;
}

Graph rooms_of(const Graph& files) {
  Graph rooms;
  for (const auto& [file, included] : files) {
    std::set<std::string>& below = rooms[folder_of(file)];
    for (const std::string& other : included) {
      if (folder_of(other) != folder_of(file)) below.insert(folder_of(other));
    }
  }
  return rooms;
}

// What is left when everything that includes nothing is taken away, again and again: the circles,
// and what includes them.
Graph without_ground(Graph graph) {
  while (true) {
    std::vector<std::string> ground;
    for (const auto& [name, below] : graph) {
      if (below.empty()) ground.push_back(name);
    }
    if (ground.empty()) return graph;
    for (const std::string& name : ground) graph.erase(name);
    for (auto& [name, below] : graph) {
      for (const std::string& gone : ground) below.erase(gone);
    }
  }
}

// The same from the other end too, which leaves circles and what lies between them.
std::vector<std::string> circles_in(const Graph& graph) {
  Graph upwards;
  for (const auto& [name, below] : without_ground(graph)) {
    upwards[name];
    for (const std::string& other : below) upwards[other].insert(name);
  }
  std::vector<std::string> names;
  for (const auto& [name, above] : without_ground(std::move(upwards))) names.push_back(name);
  return names;
}

TEST_CASE("Every room includes only the rooms below it", "[conventions]") {
  int includes = 0;
  for (const auto& [file, included] : read_includes()) {
    const Room* room = find_room(folder_of(file));
    INFO(file);
    REQUIRE(room != nullptr);
    for (const std::string& other : included) {
      if (folder_of(other) == folder_of(file)) continue;
      ++includes;
      INFO("includes " << other);
      CHECK(may_include(*room, folder_of(other)));
    }
  }
  CHECK(includes > 200);
}

TEST_CASE("The order of the rooms is an order", "[conventions]") {
  std::vector<std::string> built;
  for (const Room& room : kRooms) {
    for (const std::string& name : room.below) {
      INFO(room.name << " on " << name);
      CHECK(std::any_of(built.begin(), built.end(), [&](const std::string& below) {
        return is_within(below, name) || below == name;
      }));
    }
    built.push_back(room.name);
  }
}

TEST_CASE("No includes go in a circle", "[conventions]") {
  Graph files = read_includes();
  CHECK(files.size() > 250);
  // The public header ends with its own implementation, for which it is included first.
  files["api/engram/engram_impl.h"].erase("api/engram/engram.h");
  CHECK(circles_in(files) == std::vector<std::string>{});
  CHECK(circles_in(rooms_of(files)) == std::vector<std::string>{});
}

TEST_CASE("Circles are found", "[conventions]") {
  CHECK(circles_in({{"a", {"b", "c"}}, {"b", {"c"}}, {"c", {}}}).empty());
  CHECK(circles_in({{"a", {"b"}}, {"b", {"c"}}, {"c", {"b", "d"}}, {"d", {}}}) ==
        std::vector<std::string>{"b", "c"});
  CHECK(find_room("tasks/no_such_family")->name == "tasks/*");
  CHECK(find_room("tasks/common")->name == "tasks/common");
  CHECK(find_room("nowhere") == nullptr);
  CHECK_FALSE(may_include(*find_room("tasks/rotate"), "tasks/remember"));
  CHECK_FALSE(may_include(*find_room("tasks/rotate"), "tasks/registry.cc"));
  CHECK_FALSE(may_include(*find_room("core/base"), "core/math"));
}

}  // namespace
}  // namespace engram
