#include "protocol/make/baseline_scores.h"

#include <catch2/catch.hpp>

#include "tasks/registry.h"

namespace engram {
namespace {

TEST_CASE("Every task of the benchmark has a ceiling, with shares from 0 to 1", "[ceilings]") {
  for (const RegistryEntry& entry : registry()) {
    INFO(entry.id);
    const BaselineScores* baseline = find_baseline_scores(entry.id);
    REQUIRE(baseline != nullptr);
    for (const double share : {baseline->blind, baseline->sweep, baseline->oracle}) {
      CHECK(share >= 0);
      CHECK(share <= 1);
    }
    CHECK((baseline->oracle_answer < 0) == (baseline->blind_answer < 0));
  }
  CHECK(find_baseline_scores("RememberColor7-Slow-v0") == nullptr);
}

TEST_CASE("The memory score is 0 for the sweep and 1 for the oracle", "[ceilings]") {
  const BaselineScores baseline = {.id = "", .blind = 0.1, .sweep = 0.2, .oracle = 0.8};
  CHECK(memory_score(baseline, 0.2).value() == Approx(0));
  CHECK(memory_score(baseline, 0.8).value() == Approx(1));
  CHECK(memory_score(baseline, 0.5).value() == Approx(0.5));
  CHECK(memory_score(baseline, 0.1).value() < 0);
  // Far below a sweep that is nearly as good as the oracle.
  CHECK(memory_score({.id = "", .blind = 0.1, .sweep = 0.93, .oracle = 1}, 0.1).value() == -1);
}

TEST_CASE("Tasks that need no memory have no memory score", "[ceilings]") {
  CHECK_FALSE(memory_score({.id = "", .blind = 1, .sweep = 1, .oracle = 1}, 1).has_value());
  CHECK_FALSE(memory_score({.id = "", .blind = 0, .sweep = 0.96, .oracle = 1}, 1).has_value());
}

}  // namespace
}  // namespace engram
