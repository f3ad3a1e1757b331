// Class constants against the published ones, all keys of all tasks of this version.
#include <catch2/catch.hpp>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <variant>

#include "core/base/constant.h"
#include "protocol/io/json.h"
#include "protocol/make/variants.h"
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

// What `engram info ID --json` prints, as users pass it back.
ConstantTable read_back(const ConstantTable& constants) {
  return parse_constants(to_text(Json(constants)));
}

TEST_CASE("Every constant can be given as the description prints it", "[constants]") {
  int given = 0;
  for (const std::string& id : test::implemented_ids()) {
    INFO(id);
    const auto task = make_task(id);
    const ConstantTable printed = read_back(published_constants(task->info().constants));
    const auto again = make_task(id, printed);
    CHECK(published_constants(again->info().constants) ==
          published_constants(task->info().constants));
    CHECK(changed_constants(again->info().constants).empty());
    CHECK(again->info().canonical == task->info().canonical);
    CHECK(again->document() == task->document());
    // One at a time, and those that can be changed in their other form.
    for (const auto& constant : printed) {
      INFO(constant.first);
      CHECK_NOTHROW(make_task(id, {constant}));
      ++given;
    }
    ConstantTable kept;
    for (const TaskConstant& constant : task->info().constants) {
      if (constant.changeable()) kept.emplace_back(constant.name, constant.value);
    }
    CHECK(changed_constants(make_task(id, read_back(kept))->info().constants).empty());
  }
  CHECK(given > 2000);
}

TEST_CASE("What nobody can change is refused with its value", "[constants]") {
  CHECK_THROWS_WITH(
      make_task("TimedTransferEasy-VLA-v0", {{"SUCCESS_BONUS", 1.0}}),
      Catch::Contains("constant 'SUCCESS_BONUS': 1 given, 30 allowed: nobody can change it"));
}

}  // namespace
}  // namespace engram
