#include "tasks/registry.h"

#include <catch2/catch.hpp>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/task/task.h"
#include "tests/tasks/benchmark_table.h"

namespace engram {
namespace {

using test::benchmark, test::BenchmarkRow;

BenchmarkRow to_row(const RegistryEntry& entry) {
  return {std::string(entry.id),          std::string(entry.family),
          std::to_string(entry.horizon),  std::string(split_name(entry.split)),
          std::string(entry.memory_type), entry.canonical ? "yes" : "no",
          std::string(entry.instruction)};
}

TEST_CASE("The registry equals the published table in every column", "[registry]") {
  CHECK(benchmark().size() == 97);
  for (const BenchmarkRow& row : benchmark()) {
    INFO(row[0]);
    const RegistryEntry* entry = find_entry(row[0]);
    REQUIRE(entry != nullptr);
    CHECK(to_row(*entry) == row);
  }
}

TEST_CASE("Tasks stand in the published order", "[registry]") {
  std::vector<std::string_view> published;
  for (const BenchmarkRow& row : benchmark()) published.emplace_back(row[0]);
  std::vector<std::string_view> registered;
  for (const RegistryEntry& entry : registry()) {
    if (test::is_benchmark_id(entry.id)) registered.push_back(entry.id);
  }
  CHECK(registered == published);
}

TEST_CASE("Every task belongs to the family that lists it", "[registry]") {
  for (const RegistryEntry& entry : registry()) {
    INFO(entry.id);
    REQUIRE(entry.definition != nullptr);
    CHECK(entry.definition->name == entry.family);
    CHECK(make_task(entry.id)->info().family == entry.family);
  }
}

TEST_CASE("The registry has the published number of tasks per split and memory type",
          "[registry]") {
  std::map<std::string, int> counts;
  std::set<std::string_view> ids;
  for (const RegistryEntry& entry : registry()) {
    ids.insert(entry.id);
    if (test::is_benchmark_id(entry.id)) {
      ++counts[std::string(split_name(entry.split)) + ' ' + std::string(entry.memory_type)];
    }
    CHECK(entry.canonical == (entry.split != Split::kExtended && entry.split != Split::kRl));
    if (entry.canonical) {
      CHECK(entry.split == (entry.horizon <= 200   ? Split::kShort
                            : entry.horizon <= 601 ? Split::kMedium
                                                   : Split::kLong));
    }
  }
  CHECK(ids.size() == registry().size());
  std::vector<std::string> lines;
  lines.reserve(counts.size());
  for (const auto& [kind, count] : counts) lines.push_back(kind + ": " + std::to_string(count));
  // In alphabetical order.
  CHECK(lines == std::vector<std::string>{
                     "extended Checklist: 6", "extended Spatial: 1",  "long Capacity: 6",
                     "long Checklist: 3",     "long Procedural: 3",   "long Prospective: 2",
                     "long Sequential: 3",    "long Temporal: 5",     "medium Capacity: 6",
                     "medium Checklist: 1",   "medium Object: 9",     "medium Procedural: 3",
                     "medium Prospective: 2", "medium Sequential: 3", "medium Temporal: 4",
                     "medium Tracking: 2",    "short Negative: 9",    "short Object: 9",
                     "short Prospective: 1",  "short Spatial: 14",    "short Temporal: 3",
                     "short Tracking: 2"});
}

TEST_CASE("The RL tasks stand behind the VLA tasks, with horizon and memory type as published",
          "[registry][rl]") {
  struct Row {
    const char* id;
    int horizon;
    const char* memory_type;
  };
  constexpr Row kRows[] = {
      {"ShellGameTouch-v0", 90, "Object"},
      {"ShellGamePush-v0", 90, "Object"},
      {"ShellGamePick-v0", 90, "Object"},
      {"RememberColor3-v0", 60, "Object"},
      {"RememberColor5-v0", 60, "Object"},
      {"RememberColor9-v0", 60, "Object"},
      {"RememberShape3-v0", 60, "Object"},
      {"RememberShape5-v0", 60, "Object"},
      {"RememberShape9-v0", 60, "Object"},
      {"RememberShapeAndColor3x2-v0", 60, "Object"},
      {"RememberShapeAndColor3x3-v0", 60, "Object"},
      {"RememberShapeAndColor5x3-v0", 60, "Object"},
      {"SeqOfColors3-v0", 120, "Capacity"},
      {"SeqOfColors5-v0", 120, "Capacity"},
      {"SeqOfColors7-v0", 120, "Capacity"},
      {"ChainOfColors3-v0", 120, "Sequential"},
      {"ChainOfColors5-v0", 120, "Sequential"},
      {"ChainOfColors7-v0", 120, "Sequential"},
      {"BunchOfColors3-v0", 120, "Capacity"},
      {"BunchOfColors5-v0", 120, "Capacity"},
      {"BunchOfColors7-v0", 120, "Capacity"},
      {"InterceptSlow-v0", 90, "Spatial"},
      {"InterceptMedium-v0", 90, "Spatial"},
      {"InterceptFast-v0", 90, "Spatial"},
      {"InterceptGrabSlow-v0", 90, "Spatial"},
      {"InterceptGrabMedium-v0", 90, "Spatial"},
      {"InterceptGrabFast-v0", 90, "Spatial"},
      {"RotateLenientPos-v0", 90, "Spatial"},
      {"RotateLenientPosNeg-v0", 90, "Spatial"},
      {"RotateStrictPos-v0", 90, "Object"},
      {"RotateStrictPosNeg-v0", 90, "Object"},
      {"TakeItBack-v0", 180, "Spatial"},
  };
  std::size_t first = 0;
  while (first < registry().size() && registry()[first].split != Split::kRl) ++first;
  CHECK(first == benchmark().size());
  const auto rl = registry().subspan(first);
  CHECK(rl.size() == std::size(kRows));
  for (const Row& row : kRows) {
    INFO(row.id);
    const RegistryEntry* entry = find_entry(row.id);
    REQUIRE(entry != nullptr);
    CHECK(entry->split == Split::kRl);
    CHECK(entry->horizon == row.horizon);
    CHECK(entry->memory_type == row.memory_type);
    CHECK(entry->control_mode == ControlMode::kPdJointDeltaPos);
    CHECK(entry->index >= static_cast<int>(first));
    CHECK_FALSE(entry->instruction.empty());
  }
}

TEST_CASE("Tasks are found by their exact id", "[registry]") {
  for (const RegistryEntry& entry : registry()) CHECK(find_entry(entry.id) == &entry);
  CHECK(find_entry("") == nullptr);
  CHECK(find_entry("RememberColor9") == nullptr);
  CHECK(find_entry("remembercolor9-VLA-v0") == nullptr);
}

TEST_CASE("A misspelt id leads to the one that was meant", "[registry]") {
  for (const RegistryEntry& entry : registry()) CHECK(nearest_id(entry.id) == entry.id);
  CHECK(nearest_id("RememberColour9-VLA-v0") == "RememberColor9-VLA-v0");
  CHECK(nearest_id("remembercolor9-vla-v0") == "RememberColor9-VLA-v0");
  CHECK(nearest_id("RememberColor9") == "RememberColor9-v0");
  CHECK(nearest_id("RememberColor9-v1") == "RememberColor9-v0");
  CHECK(nearest_id("TakeItBak") == "TakeItBack-v0");
  CHECK(nearest_id("SeqOfColor5-Long-VLA-v0") == "SeqOfColors5-Long-VLA-v0");
}

TEST_CASE("Refusals of unknown ids name what may be meant", "[registry]") {
  CHECK_THROWS_WITH(
      require_entry("RememberColor3"),
      Catch::Contains("did you mean 'RememberColor3-VLA-v0' or 'RememberColor3-v0'?"));
  CHECK_THROWS_WITH(require_entry("RememberColour9-VLA-v0"),
                    "no task 'RememberColour9-VLA-v0'; did you mean 'RememberColor9-VLA-v0'? "
                    "`engram list` shows all");
  CHECK_THROWS_WITH(require_entry("MugSwap2-v0"),
                    Catch::Contains("FILE.py:MugSwap2-v0, --tasks FILE.py, or ENGRAM_TASKS"));
  CHECK_THROWS_WITH(require_entry("mug_swap.py"),
                    "no task 'mug_swap.py'; it is a file; mug_swap.py:ID names a task of it");
}

TEST_CASE("Any text leads to some id, soon", "[registry]") {
  CHECK(find_entry(nearest_id("")) != nullptr);
  CHECK(find_entry(nearest_id(std::string(1'000'000, 'x'))) != nullptr);
}

TEST_CASE("Constants are merged by name, and later values win", "[registry]") {
  const ConstantTable base = {{"COLORS", 9}, {"GOAL_THRESH", 0.1}};
  const ConstantTable others = {{"GOAL_THRESH", 0.2}, {"CUBES", 3}};
  const ConstantTable merged = merge_constants(base, others);
  CHECK((merged == ConstantTable{{"COLORS", 9}, {"GOAL_THRESH", 0.2}, {"CUBES", 3}}));
  CHECK((merge_constants(base, {}) == base));
}

TEST_CASE("max_episode_steps sets the horizon, whatever constants say", "[registry]") {
  const char* id = "RememberColor3-VLA-v0";
  const int horizon = require_entry(id).horizon;
  CHECK(make_task(id)->info().horizon == horizon);
  CHECK(make_task(id, {{"max_episode_steps", 90}})->info().horizon == 90);
  CHECK(make_task(id, {{"max_episode_steps", 90}}, 40)->info().horizon == 40);
  // A user may truncate too early to succeed; a constant may not.
  CHECK(make_task(id, {}, 1)->info().horizon == 1);
  CHECK_THROWS_AS(make_task(id, {{"max_episode_steps", 1}}), Error);
}

TEST_CASE("An entry stands at its index", "[registry]") {
  for (const RegistryEntry* entry : all_entries()) CHECK(&entry_at(entry->index) == entry);
  CHECK(all_entries().size() >= registry().size());
}

}  // namespace
}  // namespace engram
