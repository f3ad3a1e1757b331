// Class constants against the published ones, all keys of all tasks of this version.
#include <catch2/catch.hpp>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <variant>

#include "core/base/constant.h"
#include "tests/build_paths.h"
#include "tests/env_helpers.h"
#include "tests/tasks/benchmark_table.h"

namespace engram {
namespace {

using nlohmann::json;

json to_json(const Constant& constant);

struct Converter {
  template <class T>
  json operator()(const T& value) const {
    return value;
  }
  json operator()(const ConstantList& list) const {
    json out = json::array();
    for (const Constant& element : list) out.push_back(to_json(element));
    return out;
  }
  json operator()(const ConstantTable& table) const {
    json out = json::object();
    for (const auto& [key, value] : table) out[key] = to_json(value);
    return out;
  }
};

json to_json(const Constant& constant) { return std::visit(Converter{}, constant.value); }

TEST_CASE("Class constants equal the published ones", "[constants]") {
  std::ifstream file(std::string(test::kData) + "/constants.json");
  const json published = json::parse(file);
  int compared = 0;
  for (const test::BenchmarkRow& row : test::benchmark()) {
    const std::string& id = row[0];
    INFO(id);
    REQUIRE(published.contains(id));
    json given = json::object();
    const auto task = make_task(id);
    for (const auto& [name, value] : published_constants(task->info().constants)) {
      CHECK_FALSE(given.contains(name));
      given[name] = to_json(value);
    }
    CHECK(given.size() == published[id].size());
    for (const auto& [name, value] : published[id].items()) {
      INFO(name);
      REQUIRE(given.contains(name));
      CHECK(given[name] == value);
      ++compared;
    }
  }
  CHECK(compared > 50);
}

TEST_CASE("Tasks know what the registry knows", "[constants]") {
  for (const std::string& id : test::implemented_ids()) {
    const RegistryEntry& entry = require_entry(id);
    const auto task = make_task(id);
    const TaskInfo& info = task->info();
    CHECK(info.id == id);
    CHECK(info.family == entry.family);
    CHECK(info.horizon == entry.horizon);
    CHECK(info.split == split_name(entry.split));
    CHECK(info.memory_type == entry.memory_type);
    CHECK(info.instruction == entry.instruction);
    CHECK(info.canonical == entry.canonical);
    CHECK(info.candidates >= 1);
    CHECK(info.success_reward > 0);
  }
}

}  // namespace
}  // namespace engram
