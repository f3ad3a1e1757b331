#include <algorithm>
#include <catch2/catch.hpp>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "protocol/make/make.h"
#include "tests/apps/command.h"

namespace engram::test {

TEST_CASE("list: the whole registry, in order", "[apps]") {
  const ParsedJson tasks = engram_command("list --json").json();
  REQUIRE(tasks.size() == registry().size());
  for (std::size_t i = 0; i < tasks.size(); ++i) {
    const RegistryEntry& entry = registry()[i];
    const ParsedJson& task = tasks[i];
    CHECK(keys_of(task) == std::vector<std::string>{"id", "family", "split", "memory_type",
                                                    "horizon", "canonical", "instruction",
                                                    "action_dim", "state_dim", "candidates"});
    CHECK(task["id"] == entry.id);
    CHECK(task["horizon"] == entry.horizon);
    const auto batch = make(entry.id);
    CHECK(task["action_dim"] == batch->action_dim());
    CHECK(task["action_dim"] == (entry.split == Split::kRl ? 8 : 7));
    CHECK(task["state_dim"] == batch->state_dim());
    CHECK(task["candidates"] == batch->info().candidates);
  }
}

TEST_CASE("list: filters", "[apps]") {
  const ParsedJson tasks =
      engram_command("list --split short --family RememberColor --json").json();
  REQUIRE(tasks.size() == 3);
  for (const ParsedJson& task : tasks) CHECK(task["family"] == "RememberColor");
  CHECK(tasks[2]["candidates"] == 9);
  const CommandResult table = engram_command("list --split long");
  CHECK(table.code == 0);
  CHECK_THAT(table.out, Catch::Contains("22 tasks"));
}

TEST_CASE("list: the benchmark's own table", "[apps]") {
  const CommandResult all = engram_command("list --csv");
  REQUIRE(all.code == 0);
  std::istringstream lines(all.out);
  std::string line;
  REQUIRE(std::getline(lines, line));
  CHECK(line == "id;Name;Max Length;Memory Type;Horizon Split;Data Source;language_instruction");
  std::map<std::string, int> splits;
  int count = 0;
  while (std::getline(lines, line)) {
    ++count;
    std::vector<std::string> cells;
    std::istringstream cut(line);
    for (std::string cell; std::getline(cut, cell, ';');) cells.push_back(cell);
    REQUIRE(cells.size() == 7);
    CHECK(cells[0] == std::to_string(count));
    const RegistryEntry& entry = require_entry(cells[1]);
    CHECK(entry.canonical);
    CHECK(std::stoi(cells[2]) == entry.horizon);
    CHECK(cells[3] == entry.memory_type);
    ++splits[cells[4]];
    CHECK((cells[5] == "PPO" || cells[5] == "Motion Planning"));
    CHECK(cells[6] == '"' + std::string(entry.instruction) + '"');
  }
  CHECK(splits == std::map<std::string, int>{{"Short", 38}, {"Medium", 30}, {"Long", 22}});
  const std::string some = engram_command("list --csv --family RememberColor").out;
  CHECK_THAT(some, Catch::Contains("RememberColor3-VLA-v0;25;Object;Short;PPO;\"Observe"));
  CHECK_THAT(some,
             Catch::Contains("RememberColor3-Long-VLA-v0;600;Object;Medium;Motion Planning;"));
  CHECK(std::count(some.begin(), some.end(), '\n') == 7);
  require_refusal("list --csv --split extended", 2, "90 tasks");
  require_refusal("list --csv --json", 2, "--json");
}

}  // namespace engram::test
