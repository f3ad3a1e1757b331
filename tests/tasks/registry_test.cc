#include <catch2/catch.hpp>
#include <fstream>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "tasks/registry_table.h"

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
  const std::vector<Row> table = read_table(ENGRAM_TEST_DATA "/registry.csv");
  REQUIRE(table.size() == registry().size() + 1);
  REQUIRE(table[0] == Row{"id", "family", "horizon", "split", "memory_type", "canonical",
                          "language_instruction"});
  for (std::size_t i = 0; i < registry().size(); ++i) {
    const RegistryEntry& entry = registry()[i];
    CHECK(table[i + 1] == Row{std::string(entry.id), std::string(entry.family),
                              std::to_string(entry.horizon), std::string(split_name(entry.split)),
                              std::string(entry.memory_type), entry.canonical ? "yes" : "no",
                              std::string(entry.instruction)});
  }
}

TEST_CASE("The registry has the published number of tasks per split and memory type",
          "[registry]") {
  using Counts = std::map<std::string_view, int>;
  std::map<Split, Counts> counts;
  std::map<Split, int> totals;
  std::set<std::string_view> ids;
  for (const RegistryEntry& entry : registry()) {
    ++counts[entry.split][entry.memory_type];
    ++totals[entry.split];
    ids.insert(entry.id);
    CHECK(entry.canonical == (entry.split != Split::kExtended));
    if (entry.canonical) {
      CHECK(entry.split == (entry.horizon <= 200   ? Split::kShort
                            : entry.horizon <= 601 ? Split::kMedium
                                                   : Split::kLong));
    }
  }
  CHECK(ids.size() == 97);
  CHECK(totals ==
        std::map<Split, int>{
            {Split::kShort, 38}, {Split::kMedium, 30}, {Split::kLong, 22}, {Split::kExtended, 7}});
  CHECK(counts[Split::kShort] == Counts{{"Spatial", 14},
                                        {"Object", 9},
                                        {"Negative", 9},
                                        {"Temporal", 3},
                                        {"Tracking", 2},
                                        {"Prospective", 1}});
  CHECK(counts[Split::kMedium] == Counts{{"Object", 9},
                                         {"Capacity", 6},
                                         {"Temporal", 4},
                                         {"Sequential", 3},
                                         {"Procedural", 3},
                                         {"Tracking", 2},
                                         {"Prospective", 2},
                                         {"Checklist", 1}});
  CHECK(counts[Split::kLong] == Counts{{"Capacity", 6},
                                       {"Temporal", 5},
                                       {"Checklist", 3},
                                       {"Procedural", 3},
                                       {"Sequential", 3},
                                       {"Prospective", 2}});
  CHECK(counts[Split::kExtended] == Counts{{"Checklist", 6}, {"Spatial", 1}});
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
