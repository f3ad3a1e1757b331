#include "protocol/make/benchmark_csv.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <string>
#include <vector>

namespace engram {
namespace {

TEST_CASE("The benchmark's table has its canonical tasks, numbered", "[benchmark_csv]") {
  const std::string table = benchmark_csv(all_entries());
  CHECK(std::ranges::count(table, '\n') == 1 + 90);
  CHECK(table.starts_with(
      "id;Name;Max Length;Memory Type;Horizon Split;Data Source;language_instruction\n"
      "1;ShellGameTouch-VLA-v0;30;Spatial;Short;PPO;\"Observe which cup hides the ball, wait, "
      "then touch that cup.\"\n"));
  CHECK(table.find("ShellGamePick") == std::string::npos);
  CHECK(table.find("BatteriesCheckerHard-9") == std::string::npos);
  CHECK(table.find(";TakeItBack-VLA-v0;60;Spatial;Short;PPO;") != std::string::npos);
  CHECK(table.find(";TimedTransferEasy-VLA-v0;200;Temporal;Short;Motion Planning;") ==
        table.find(";TimedTransferEasy-VLA-v0"));
}

TEST_CASE("A part of the table keeps the numbers of the whole", "[benchmark_csv]") {
  const std::vector<const RegistryEntry*> one = {&require_entry("ShellGamePush-VLA-v0")};
  const std::string table = benchmark_csv(one);
  CHECK(std::ranges::count(table, '\n') == 2);
  CHECK(table.find("\n2;ShellGamePush-VLA-v0;30;") != std::string::npos);
}

}  // namespace
}  // namespace engram
