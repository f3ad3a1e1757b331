#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "protocol/batch/make.h"
#include "tests/apps/command.h"

namespace engram::tests {

TEST_CASE("list: the whole registry, in order", "[apps]") {
  const Json tasks = engram_command("list --json").json();
  REQUIRE(tasks.size() == registry().size());
  for (std::size_t i = 0; i < tasks.size(); ++i) {
    const RegistryEntry& entry = registry()[i];
    const Json& task = tasks[i];
    CHECK(keys_of(task) == std::vector<std::string>{"id", "family", "split", "memory_type",
                                                    "horizon", "canonical", "instruction",
                                                    "action_dim", "state_dim", "candidates"});
    CHECK(task["id"] == entry.id);
    CHECK(task["horizon"] == entry.horizon);
    CHECK(task["action_dim"] == 7);
    const auto env = make(entry.id);
    CHECK(task["state_dim"] == env->state_dim());
    CHECK(task["candidates"] == env->info().candidates);
  }
}

TEST_CASE("list: filters", "[apps]") {
  const Json tasks = engram_command("list --split short --family RememberColor --json").json();
  REQUIRE(tasks.size() == 3);
  for (const Json& task : tasks) CHECK(task["family"] == "RememberColor");
  CHECK(tasks[2]["candidates"] == 9);
  const CommandResult table = engram_command("list --split long");
  CHECK(table.code == 0);
  CHECK_THAT(table.out, Catch::Contains("22 tasks"));
}

}  // namespace engram::tests
