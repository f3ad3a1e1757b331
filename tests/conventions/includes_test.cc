// Order of the modules: includes point downwards only, and units (a header with the source file of
// the same name) include one another in no circle. Read from the sources themselves.
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

// A module is a folder, or all folders in one ("tasks/*").
struct Module {
  std::string name;
  std::vector<std::string> below;  // what it may include
};

// From the leaves up.
const std::vector<Module> kModules = {
    {"core/base", {}},
    {"core/math", {"core/base"}},
    {"core/threads", {"core/base"}},
    {"core/robot", {"core/base", "core/math"}},
    {"core/scene", {"core/base", "core/math", "core/threads", "core/robot"}},
    {"core/collision", {"core/base", "core/math", "core/robot", "core/scene"}},
    {"core/contact", {"core/base", "core/math", "core/robot", "core/scene", "core/collision"}},
    {"core/sim",
     {"core/base", "core/math", "core/robot", "core/scene", "core/collision", "core/contact"}},
    {"core/image", {"core/base", "core/math", "core/robot", "core/scene", "core/sim"}},
    {"core/task", {"core/base", "core/math", "core/scene", "core/sim"}},
    {"core/perturb", {"core/base", "core/robot", "core/image", "core/sim", "core/task"}},
    {"core/observe", {"core/base", "core/sim", "core/task"}},
    {"core/batch", {"core/*"}},
    {"mjcf", {"core/base", "core/math", "core/task"}},
    {"render/cpu", {"core/base", "core/math", "core/threads", "core/image"}},
    {"render/egl", {"core/base", "core/math", "core/image", "render/cpu"}},
    {"render", {"core/*", "render/cpu", "render/egl"}},
    {"media", {"core/base", "core/image"}},
    {"media/libav", {"core/base", "media"}},
    {"tasks", {"core/*"}},
    {"tasks/common", {"core/*", "mjcf", "tasks"}},
    {"tasks/*", {"core/*", "mjcf", "tasks", "tasks/common"}},
    {"tasks/custom", {"core/*", "mjcf", "tasks", "tasks/common"}},
    {"tasks/registry.cc", {"core/*", "tasks", "tasks/*"}},
    {"protocol/io", {"core/base"}},
    {"protocol/parallel", {"core/base", "core/threads", "protocol/io"}},
    {"protocol/parallel/mpi", {"core/base", "protocol/parallel"}},
    {"protocol/make", {"core/*", "tasks", "render", "protocol/io", "protocol/parallel"}},
    {"protocol/custom_tasks", {"core/base", "core/task", "mjcf", "tasks/custom", "protocol/io"}},
    {"protocol/eval/policies", {"core/*", "protocol/io", "protocol/parallel", "protocol/make"}},
    {"protocol/eval/run",
     {"core/*", "media", "protocol/io", "protocol/parallel", "protocol/make",
      "protocol/eval/policies"}},
    {"protocol/eval/results",
     {"core/*", "protocol/io", "protocol/parallel", "protocol/make", "protocol/eval/policies",
      "protocol/eval/run"}},
    {"protocol/eval",
     {"protocol/io", "protocol/parallel", "protocol/eval/run", "protocol/eval/results"}},
    {"protocol/eval/probe",
     {"core/*", "tasks", "protocol/io", "protocol/parallel", "protocol/make",
      "protocol/eval/policies", "protocol/eval/run", "protocol/eval/results"}},
    {"protocol/training", {"core/*"}},
    {"protocol/datasets",
     {"core/*", "media", "tasks", "protocol/io", "protocol/parallel", "protocol/make"}},
    {"api/engram", {}},
    {"api",
     {"core/*", "tasks/custom", "render", "render/egl", "media", "protocol/*", "api/engram"}},
    {"bench", {"core/*", "tasks", "render", "render/cpu", "protocol/*"}},
    {"apps", {"core/base", "core/batch", "tasks/custom", "protocol/*", "api", "bench"}},
    {"apps/examples", {"api/engram"}},
    {"python/src", {"api/engram"}},
};

// The one file that knows all families; its header lies below them.
constexpr const char* kRegistry = "tasks/registry.cc";

bool is_within(const std::string& module, const std::string& name) {
  if (!name.ends_with("/*")) return module == name;
  const std::string prefix = name.substr(0, name.size() - 1);
  return module.starts_with(prefix) && module != kRegistry;
}

// Nullptr for a folder that is no module.
const Module* find_module(const std::string& folder) {
  const auto named = [&](auto&& match) {
    const auto found = std::find_if(kModules.begin(), kModules.end(), match);
    return found == kModules.end() ? nullptr : &*found;
  };
  const Module* exact = named([&](const Module& module) { return module.name == folder; });
  return exact != nullptr
             ? exact
             : named([&](const Module& module) { return is_within(folder, module.name); });
}

bool may_include(const Module& module, const std::string& other) {
  return std::any_of(module.below.begin(), module.below.end(),
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

std::string unit_of(const std::string& file) { return file.substr(0, file.rfind('.')); }

// Headers joined with the source files of the same name.
Graph units_of(const Graph& files) {
  Graph units;
  for (const auto& [file, included] : files) {
    std::set<std::string>& below = units[unit_of(file)];
    for (const std::string& other : included) {
      if (unit_of(other) != unit_of(file)) below.insert(unit_of(other));
    }
  }
  return units;
}

Graph modules_of(const Graph& files) {
  Graph modules;
  for (const auto& [file, included] : files) {
    std::set<std::string>& below = modules[folder_of(file)];
    for (const std::string& other : included) {
      if (folder_of(other) != folder_of(file)) below.insert(folder_of(other));
    }
  }
  return modules;
}

// What is left when everything that includes nothing is taken away, again and again: the circles,
// and what includes them.
Graph without_leaves(Graph graph) {
  while (true) {
    std::vector<std::string> leaves;
    for (const auto& [name, below] : graph) {
      if (below.empty()) leaves.push_back(name);
    }
    if (leaves.empty()) return graph;
    for (const std::string& name : leaves) graph.erase(name);
    for (auto& [name, below] : graph) {
      for (const std::string& gone : leaves) below.erase(gone);
    }
  }
}

// Strips leaves from both ends, which leaves circles and what lies between them.
std::vector<std::string> circles_in(const Graph& graph) {
  Graph upwards;
  for (const auto& [name, below] : without_leaves(graph)) {
    upwards[name];
    for (const std::string& other : below) upwards[other].insert(name);
  }
  std::vector<std::string> names;
  for (const auto& [name, above] : without_leaves(std::move(upwards))) names.push_back(name);
  return names;
}

TEST_CASE("Every module includes only the modules below it", "[conventions]") {
  int includes = 0;
  for (const auto& [file, included] : read_includes()) {
    const Module* module = find_module(folder_of(file));
    INFO(file);
    REQUIRE(module != nullptr);
    for (const std::string& other : included) {
      if (folder_of(other) == folder_of(file)) continue;
      ++includes;
      INFO("includes " << other);
      CHECK(may_include(*module, folder_of(other)));
    }
  }
  CHECK(includes > 200);
}

TEST_CASE("The order of the modules is an order", "[conventions]") {
  std::vector<std::string> built;
  for (const Module& module : kModules) {
    for (const std::string& name : module.below) {
      INFO(module.name << " on " << name);
      CHECK(std::any_of(built.begin(), built.end(), [&](const std::string& below) {
        return is_within(below, name) || below == name;
      }));
    }
    built.push_back(module.name);
  }
}

TEST_CASE("No includes go in a circle", "[conventions]") {
  Graph files = read_includes();
  CHECK(files.size() > 250);
  // The public header ends with its own implementation, for which it is included first.
  files["api/engram/engram_impl.h"].erase("api/engram/engram.h");
  CHECK(circles_in(files) == std::vector<std::string>{});
  CHECK(circles_in(units_of(files)) == std::vector<std::string>{});
  CHECK(circles_in(modules_of(files)) == std::vector<std::string>{});
}

TEST_CASE("Circles are found", "[conventions]") {
  CHECK(circles_in({{"a", {"b", "c"}}, {"b", {"c"}}, {"c", {}}}).empty());
  CHECK(circles_in({{"a", {"b"}}, {"b", {"c"}}, {"c", {"b", "d"}}, {"d", {}}}) ==
        std::vector<std::string>{"b", "c"});
  // a.h includes b.h, and b.cc includes a.h: no circle of files, but one of units.
  const Graph crossed = {{"a.h", {"b.h"}}, {"a.cc", {"a.h"}}, {"b.h", {}}, {"b.cc", {"a.h"}}};
  CHECK(circles_in(crossed).empty());
  CHECK(circles_in(units_of(crossed)) == std::vector<std::string>{"a", "b"});
  CHECK(find_module("tasks/no_such_family")->name == "tasks/*");
  CHECK(find_module("tasks/common")->name == "tasks/common");
  CHECK(find_module("nowhere") == nullptr);
  CHECK_FALSE(may_include(*find_module("tasks/rotate"), "tasks/remember"));
  CHECK_FALSE(may_include(*find_module("tasks/rotate"), "tasks/registry.cc"));
  CHECK_FALSE(may_include(*find_module("core/base"), "core/math"));
}

}  // namespace
}  // namespace engram
