// Families that are registered while the process runs.
#include <array>
#include <catch2/catch.hpp>
#include <string>
#include <thread>
#include <vector>

#include "core/base/error.h"
#include "core/task/task.h"
#include "tests/env_helpers.h"

namespace engram {
namespace {

using Catch::Contains;

constexpr const char* kLike = "RememberColor3-VLA-v0";

// A task of the benchmark under another id.
std::unique_ptr<Task> make_like(const RegistryEntry& entry, const ConstantTable& constants) {
  RegistryEntry like = require_entry(kLike);
  like.id = entry.id;
  like.max_episode_steps = entry.max_episode_steps;
  return like.definition->make(like, constants);
}

constexpr Family family_of(std::string_view name, std::span<const TaskSpec> rows) {
  return {.name = name,
          .memory_type = "Object",
          .instruction = "Touch it.",
          .tasks = rows,
          .make = make_like};
}

TEST_CASE("A registered family's tasks are tasks like any other", "[registry][families]") {
  const std::size_t listed = registry().size();
  static constexpr std::array kRows = {
      TaskSpec{"OwnA-VLA-v0", 25, Split::kExtended},
      TaskSpec{"OwnB-VLA-v1", 25, Split::kExtended, 0.9, "Touch that."}};
  static constexpr Family kFamily = family_of("Own", kRows);
  const std::vector<const RegistryEntry*> before = all_entries();
  register_family(kFamily);
  const std::vector<const RegistryEntry*> after = all_entries();
  REQUIRE(after.size() == before.size() + 2);
  CHECK(std::equal(before.begin(), before.end(), after.begin()));

  const RegistryEntry& entry = require_entry("OwnB-VLA-v1");
  CHECK(&entry == after.back());
  CHECK(&entry_at(entry.index) == &entry);
  CHECK(entry.family == "Own");
  CHECK(entry.instruction == "Touch that.");
  CHECK(require_entry("OwnA-VLA-v0").instruction == "Touch it.");
  CHECK(entry.oracle_floor == 0.9);
  CHECK_FALSE(entry.canonical);
  CHECK(entry.base == "OwnB-VLA-v1");
  CHECK(nearest_id("OwnB-VLA") == "OwnB-VLA-v1");

  const auto batch = test::make_env("OwnA-VLA-v0");
  CHECK(batch->info().id == "OwnA-VLA-v0");
  batch->reset();
  test::step(*batch, Policy::kOracle);
  // The benchmark's list is as before.
  CHECK(registry().size() == listed);
}

TEST_CASE("A registered family's tasks have variants", "[registry][families]") {
  static constexpr std::array kRows = {TaskSpec{"OwnVaried-VLA-v0", 25, Split::kExtended}};
  static constexpr Family kFamily = family_of("OwnVaried", kRows);
  register_family(kFamily);
  const TaskVariant variant = {"OwnVaried-Two-v0", "OwnVaried-VLA-v0", {{"COLORS", 2}}, {}};
  register_variants({&variant, 1});
  CHECK(make_task("OwnVaried-Two-v0")->info().candidates == 2);
  CHECK(variant_of(require_entry("OwnVaried-Two-v0")) ==
        TaskVariant{"OwnVaried-Two-v0", "OwnVaried-VLA-v0", {{"COLORS", 2}}, "Touch it."});
  const TaskVariant wrong = {"OwnVaried-Many-v0", "OwnVaried-VLA-v0", {{"COLORS", 20}}, {}};
  CHECK_THROWS_WITH(register_variants({&wrong, 1}), Contains("20 given"));
}

TEST_CASE("A family of the same name replaces its own tasks", "[registry][families]") {
  static constexpr std::array kFirst = {TaskSpec{"Replaced-VLA-v0", 25, Split::kExtended}};
  static constexpr std::array kSecond = {TaskSpec{"Replaced-VLA-v0", 60, Split::kExtended},
                                         TaskSpec{"Replaced-VLA-v1", 60, Split::kExtended}};
  static constexpr Family kOld = family_of("Replaced", kFirst);
  static constexpr Family kNew = family_of("Replaced", kSecond);
  register_family(kOld);
  const RegistryEntry& old = require_entry("Replaced-VLA-v0");
  const std::size_t count = all_entries().size();
  register_family(kNew);
  CHECK(all_entries().size() == count + 1);
  const RegistryEntry& now = require_entry("Replaced-VLA-v0");
  CHECK(now.horizon == 60);
  CHECK(now.definition == &kNew);
  CHECK(now.index == old.index);
  // Who holds the old entry can go on with it.
  CHECK(old.horizon == 25);
  CHECK(old.definition == &kOld);
  CHECK(old.definition->make(old, {})->info().id == "Replaced-VLA-v0");
}

TEST_CASE("Ids that are taken or malformed are refused, with all families that came along",
          "[registry][families]") {
  static constexpr std::array kFree = {TaskSpec{"Unheard-VLA-v0", 25, Split::kExtended}};
  static constexpr Family kFreeFamily = family_of("Unheard", kFree);
  static constexpr std::array kOwn = {TaskSpec{"OwnTaken-VLA-v0", 25, Split::kExtended}};
  static constexpr Family kOwnFamily = family_of("OwnTaken", kOwn);
  register_family(kOwnFamily);
  const TaskVariant variant = {"OwnTaken-Variant-v0", kLike, {{"COLORS", 2}}, {}};
  register_variants({&variant, 1});

  struct Case {
    const char* family;
    std::vector<TaskSpec> rows;
    const char* message;
  };
  const std::vector<Case> cases = {
      {"Thief", {{kLike, 25}}, "'RememberColor3-VLA-v0' is taken, by a task of the benchmark"},
      // Not even the family of that name.
      {"RememberColor", {{kLike, 25}}, "by a task of the benchmark"},
      {"Thief", {{"OwnTaken-Variant-v0", 25}}, "is taken, by a variant"},
      {"OwnTaken", {{"OwnTaken-Variant-v0", 25}}, "is taken, by a variant"},
      {"Thief", {{"OwnTaken-VLA-v0", 25}}, "is taken, by a task of the family OwnTaken"},
      {"Thief", {{"Free-VLA-v0", 25}, {"Free-VLA-v0", 30}}, "'Free-VLA-v0' given twice"},
      {"Unheard", {{"Unheard-VLA-v0", 30}}, "'Unheard-VLA-v0' given twice"},
      {"Thief", {{"Free-VLA", 25}}, "id of a task: 'Free-VLA' given"},
      {"Thief", {{"", 25}}, "id of a task: '' given"},
      {"Thief", {{"Free-VLA-v0", 0}}, "horizon of 'Free-VLA-v0': 0 given, 1 or more"}};
  const std::size_t count = all_entries().size();
  for (const Case& one : cases) {
    INFO(one.message);
    const Family family = family_of(one.family, one.rows);
    CHECK_THROWS_WITH(register_families(std::array{&kFreeFamily, &family}), Contains(one.message));
    CHECK(all_entries().size() == count);
  }
  Family without_make = kFreeFamily;
  without_make.make = nullptr;
  CHECK_THROWS_WITH(register_family(without_make), Contains("a family without `make` given"));
  CHECK(find_entry("Unheard-VLA-v0") == nullptr);
  const TaskVariant stolen = {"OwnTaken-VLA-v0", kLike, {}, {}};
  CHECK_THROWS_WITH(register_variants({&stolen, 1}), Contains("by a task of the family OwnTaken"));
}

TEST_CASE("Entries stay where they are while families are registered", "[registry][families]") {
  static constexpr std::array kRows = {TaskSpec{"OwnStays-VLA-v0", 25, Split::kExtended}};
  static constexpr Family kFamily = family_of("OwnStays", kRows);
  register_family(kFamily);
  const RegistryEntry* entry = find_entry("OwnStays-VLA-v0");
  // For the life of the process.
  constexpr std::size_t kCount = 200;
  static std::array<std::string, kCount> ids;
  static std::array<TaskSpec, kCount> rows;
  static std::array<Family, kCount> families;
  for (std::size_t i = 0; i < kCount; ++i) {
    ids[i] = "OwnStays" + std::to_string(i) + "-VLA-v0";
    rows[i] = {ids[i], 25, Split::kExtended};
    families[i] = family_of(ids[i], {&rows[i], 1});
  }
  std::vector<std::thread> threads;
  for (std::size_t first = 0; first < 2; ++first) {
    threads.emplace_back([first] {
      for (std::size_t i = first; i < families.size(); i += 2) register_family(families[i]);
    });
  }
  for (int i = 0; i < 1000; ++i) {
    if (find_entry("OwnStays-VLA-v0") != entry) FAIL_CHECK("the entry has moved");
  }
  for (std::thread& thread : threads) thread.join();
  for (const std::string& id : ids) CHECK(find_entry(id) != nullptr);
  for (const RegistryEntry* one : all_entries()) CHECK(&entry_at(one->index) == one);
  CHECK(find_entry("OwnStays-VLA-v0") == entry);
}

}  // namespace
}  // namespace engram
