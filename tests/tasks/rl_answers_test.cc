// First answers of the RL tasks, whose episodes end at success.
#include <catch2/catch.hpp>

#include "tests/env_helpers.h"

namespace engram {
namespace {

TEST_CASE("An episode that success ends has a right first answer, or a wrong one before",
          "[answer][rl]") {
  for (const RegistryEntry& entry : registry()) {
    if (entry.split != Split::kRl) continue;
    const BatchOptions options{.num_envs = 20, .threads = 2, .auto_reset = AutoReset::kOff};
    const auto batch = test::make_env(entry.id, options);
    if (batch->info().answer.empty()) continue;
    batch->reset();
    for (int t = 0; t < entry.horizon; ++t) test::step(*batch, Policy::kOracle);
    int solved = 0;
    int right = 0;
    for (int i = 0; i < options.num_envs; ++i) {
      if (*test::row<std::uint8_t>(batch->output("success_once"), i) == 0) continue;
      ++solved;
      CHECK(*test::row<std::uint8_t>(batch->output("answered"), i) == 1);
      right += *test::row<std::uint8_t>(batch->output("first_answer_correct"), i);
    }
    INFO(entry.id);
    CHECK(solved >= 19);
    CHECK(right >= 19);
  }
}

}  // namespace
}  // namespace engram
