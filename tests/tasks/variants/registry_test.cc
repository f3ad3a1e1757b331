// Users' own ids: what they are, and what is refused.
#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "core/batch/snapshot.h"
#include "protocol/io/files.h"
#include "protocol/make/variants.h"
#include "tests/env_helpers.h"
#include "tests/temporary_folder.h"

namespace engram {
namespace {

using Catch::Contains;

void register_one(const TaskVariant& variant) { register_variants({&variant, 1}); }

ConstantTable slow(int colors) {
  return {{"COLORS", colors},
          {"CUE_PHASE_STEPS", ConstantList{30, 50}},
          {"EMPTY_PHASE_STEPS", ConstantList{30, 50}},
          {"max_episode_steps", 150}};
}

TEST_CASE("A variant is a task with an id of its own", "[variants]") {
  register_one({"RememberColor7-Slow-v0", "RememberColor9-VLA-v0", slow(7), "Touch it."});
  const RegistryEntry& entry = require_entry("RememberColor7-Slow-v0");
  CHECK(entry.horizon == 150);
  CHECK_FALSE(entry.canonical);
  CHECK(all_entries()[static_cast<std::size_t>(entry.index)] == &entry);
  CHECK(&entry_at(entry.index) == &entry);

  const auto batch = test::make_env("RememberColor7-Slow-v0");
  CHECK(batch->info().id == "RememberColor7-Slow-v0");
  CHECK(batch->info().instruction == "Touch it.");
  CHECK(batch->info().candidates == 7);
  CHECK(batch->info().horizon == 150);
  // An equal variant is no second one; a variant of it has its constants, too.
  const std::size_t count = all_entries().size();
  register_one({"RememberColor7-Slow-v0", "RememberColor9-VLA-v0", slow(7), "Touch it."});
  CHECK(all_entries().size() == count);
  register_one({"RememberColor2-Slow-v0", "RememberColor7-Slow-v0", {{"COLORS", 2}}});
  const TaskVariant variant = variant_of(require_entry("RememberColor2-Slow-v0"));
  CHECK(variant.base == "RememberColor9-VLA-v0");
  CHECK(variant.constants == slow(2));
  CHECK(variant.instruction == "Touch it.");
  // The benchmark's own tasks are as before.
  CHECK(make_task("RememberColor9-VLA-v0")->info().candidates == 9);
}

TEST_CASE("What cannot be a variant is refused and not registered", "[variants]") {
  const std::string base = "RememberColor9-VLA-v0";
  register_one({"RememberColor5-Mine-v0", base, {{"COLORS", 5}}});
  const std::size_t count = all_entries().size();
  struct Case {
    TaskVariant variant;
    const char* message;
  };
  const std::vector<Case> cases = {
      {{"RememberColor4-Mine", base}, "that end in -v and a number"},
      {{"Remember Color-v0", base}, "letters, digits"},
      {{"-v0", base}, "'-v0' given"},
      {{"RememberColor5-Mine-v0", base, {{"COLORS", 6}}}, "defined in another way"},
      {{"RememberColor3-VLA-v0", base}, "by a task of the benchmark"},
      {{"Other-v0", "RememberColour9-VLA-v0"}, "did you mean 'RememberColor9-VLA-v0'"},
      {{"Other-v0", base, {{"COLOURS", 5}}}, "did you mean 'COLORS'"},
      {{"Other-v0", base, {{"COLORS", 10}}}, "10 given, a whole number from 2 to 9 allowed"},
      {{"Other-v0", base, {{"COLORS", 2.5}}}, "2.5 given"},
      {{"Other-v0", base, {{"COLORS", "five"}}}, "'five' given"},
      {{"Other-v0", base, {{"COLORS", nullptr}}}, "null given"},
      {{"Other-v0", base, {{"COLORS", 5}, {"COLORS", 6}}}, "given twice"},
      {{"Other-v0", base, {{"CUE_PHASE_STEPS", ConstantList{5, 3}}}}, "[5, 3] given"},
      {{"Other-v0", base, {{"CUE_PHASE_STEPS", ConstantList{1, 2, 3}}}}, "[1, 2, 3] given"},
      {{"Other-v0", base, {{"CUE_PHASE_STEPS", 12}}},
       "CUE_PHASE_STEPS 12 + EMPTY_PHASE_STEPS 5 + 15 to act = 32 control steps, more than "
       "max_episode_steps 25"},
      {{"Other-v0", "RememberShapeAndColor3x3-VLA-v0", {{"BASE_SHAPES", ConstantList{"cube"}}}},
       "9 given, at most 1 shapes x 3 colours = 3 allowed"},
      {{"Other-v0", "FindImposterShapeAndColor5x3-VLA-v0", {{"SHAPE_SCALE", 0.035}}},
       "do not stand apart"},
  };
  for (const Case& one : cases) {
    INFO(one.message);
    CHECK_THROWS_WITH(register_one(one.variant), Contains(one.message));
    CHECK(all_entries().size() == count);
  }
}

TEST_CASE("A file of variants is registered as a whole or not at all", "[variants]") {
  const test::TemporaryFolder folder;
  const auto file = folder.path() / "variants.json";
  const std::size_t count = all_entries().size();
  const std::string first = R"({"id": "File-One-v0", "base": "RememberColor3-VLA-v0"})";
  struct Case {
    std::string text;
    const char* message;
  };
  const std::vector<Case> cases = {
      {"{\"variants\": [" + first + R"(, {"id": "File-Two-v0", "base": "RememberColor4-VLA-v0"}]})",
       "did you mean"},
      {"{\"variants\": [" + first + R"(, {"id": "File-Two-v0"}]})", "a text 'base' needed"},
      {"{\"variants\": [" + first + R"(, {"id": "File-Two-v0", "bas": "x"}]})", "has 'bas'"},
      {"{\"variants\": [" + first + ", 7]}", "has to be a table"},
      {"{\"variants\": 7}", "not of the form"},
      {"{\"variants\": [", "not JSON"},
  };
  for (const Case& one : cases) {
    INFO(one.text);
    write_file(file, one.text);
    CHECK_THROWS_WITH(load_variants(file), Contains(one.message) && Contains(file.string()));
    CHECK(all_entries().size() == count);
    CHECK(find_entry("File-One-v0") == nullptr);
  }
  CHECK_THROWS_WITH(load_variants(folder.path() / "none.json"), Contains("cannot be read"));

  // A later one may build on an earlier one.
  write_file(file, "{\"variants\": [" + first +
                       R"(, {"id": "File-Two-v0", "base": "File-One-v0",
                            "constants": {"COLORS": 4}}]})");
  load_variants(file);
  CHECK(all_entries().size() == count + 2);
  CHECK(make_task("File-Two-v0")->info().candidates == 4);
}

TEST_CASE("A snapshot fits tasks with the same constants alone", "[variants][snapshot]") {
  MakeOptions options{{.num_envs = 2}, {{"COLORS", 5}}};
  const auto batch = test::make_running("RememberColor9-VLA-v0", options);
  const auto saved = Snapshotter(*batch).save();
  for (const ConstantTable& other : {ConstantTable{}, ConstantTable{{"COLORS", 6}},
                                     ConstantTable{{"COLORS", 5}, {"GOAL_THRESH", 0.04}}}) {
    options.constants = other;
    const auto another = test::make_running("RememberColor9-VLA-v0", options);
    const auto before = Snapshotter(*another).save();
    CHECK_THROWS_WITH(Snapshotter(*another).restore(saved), Contains("COLORS=5"));
    CHECK(Snapshotter(*another).save() == before);
  }
  // Where an episode ends is up to the batch.
  options.constants = {{"COLORS", 5}, {"max_episode_steps", 60}};
  const auto longer = test::make_running("RememberColor9-VLA-v0", options);
  Snapshotter(*longer).restore(saved);
  CHECK(test::env_bytes(*longer, 1) == test::env_bytes(*batch, 1));
}

}  // namespace
}  // namespace engram
