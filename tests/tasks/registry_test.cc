#include <catch2/catch.hpp>
#include <fstream>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "tasks/registry_table.h"
#include "tests/build_paths.h"

namespace engram {
namespace {

using Row = std::vector<std::string>;

// The rows of a semicolon-separated file that has no quoting.
std::vector<Row> read_table(const std::string& path) {
  std::ifstream file(path);
  std::vector<Row> rows;
  for (std::string line; std::getline(file, line);) {
    std::istringstream fields(line);
    Row row;
    for (std::string field; std::getline(fields, field, ';');) row.push_back(field);
    rows.push_back(row);
  }
  return rows;
}

TEST_CASE("The registry equals registry.csv in every column", "[registry]") {
  const std::vector<Row> table = read_table(std::string(test::kData) + "/registry.csv");
  REQUIRE(table[0] == Row{"id", "family", "horizon", "split", "memory_type", "canonical",
                          "language_instruction"});
  for (std::size_t i = 0; i < registry().size(); ++i) {
    const RegistryEntry& entry = registry()[i];
    INFO("the row of registry.csv at the place of " << entry.id);
    REQUIRE(i + 1 < table.size());
    CHECK(table[i + 1] == Row{std::string(entry.id), std::string(entry.family),
                              std::to_string(entry.horizon), std::string(split_name(entry.split)),
                              std::string(entry.memory_type), entry.canonical ? "yes" : "no",
                              std::string(entry.instruction)});
  }
  CHECK(table.size() == registry().size() + 1);
}

TEST_CASE("The registry has the published number of tasks per split and memory type",
          "[registry]") {
  std::map<std::string, int> counts;
  std::set<std::string_view> ids;
  for (const RegistryEntry& entry : registry()) {
    ++counts[std::string(split_name(entry.split)) + ' ' + std::string(entry.memory_type)];
    ids.insert(entry.id);
    CHECK(entry.canonical == (entry.split != Split::kExtended));
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
  CHECK(nearest_id("RememberColor9") == "RememberColor9-VLA-v0");
  CHECK(nearest_id("RememberColor9-v0") == "RememberColor9-VLA-v0");
  CHECK(nearest_id("TakeItBak") == "TakeItBack-VLA-v0");
  CHECK(nearest_id("SeqOfColor5-Long-VLA-v0") == "SeqOfColors5-Long-VLA-v0");
}

TEST_CASE("Any text leads to some id, soon", "[registry]") {
  CHECK(find_entry(nearest_id("")) != nullptr);
  CHECK(find_entry(nearest_id(std::string(1'000'000, 'x'))) != nullptr);
}

}  // namespace
}  // namespace engram
