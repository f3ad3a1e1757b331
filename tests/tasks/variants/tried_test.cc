// Tasks with other constants: the oracle solves them, a guess succeeds as often as it should, and
// nothing is revealed after the cue.
#include "tests/tasks/variants/tried.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "core/batch/queries.h"
#include "tests/env_helpers.h"
#include "tests/tasks/leak_check.h"

namespace engram {
namespace {

// Share of episodes with success.
double success(const test::TriedVariant& variant, Policy policy, int episodes) {
  const MakeOptions options{
      {.num_envs = episodes, .seed = 4242424242, .threads = 2, .auto_reset = AutoReset::kOff},
      variant.constants()};
  const auto batch = make(variant.id, options);
  batch->reset();
  for (int step = 0; step < batch->info().horizon; ++step) test::step(*batch, policy);
  CHECK(Queries(*batch).unstable_count() == 0);
  int successes = 0;
  for (int i = 0; i < episodes; ++i) {
    successes += *test::row<std::uint8_t>(batch->output("success_once"), i);
  }
  return static_cast<double>(successes) / episodes;
}

// Every n-th of them, or of those with short episodes.
std::vector<test::TriedVariant> sample(std::size_t every, int longest) {
  std::vector<test::TriedVariant> chosen;
  std::size_t count = 0;
  for (const test::TriedVariant& variant : test::tried_variants()) {
    if (make_task(variant.id, variant.constants())->info().horizon > longest) continue;
    if (count++ % every == 0) chosen.push_back(variant);
  }
  return chosen;
}

constexpr int kAnyLength = 1'000'000;

void check_solved(const std::vector<test::TriedVariant>& variants) {
  for (const test::TriedVariant& variant : variants) {
    INFO(variant.id << " " << variant.json);
    const auto task = make_task(variant.id, variant.constants());
    const int episodes = std::clamp(20'000 / task->info().horizon, 8, 40);
    CHECK(success(variant, Policy::kOracle, episodes) >= variant.oracle_floor);
    if (variant.oracle_floor < 0.95) {
      CHECK_FALSE(variant.note.empty());
      continue;
    }
    const double chance = task->info().chance();
    const double guessed = success(variant, Policy::kBlind, episodes);
    const double sampling = 4 * std::sqrt(chance * (1 - chance) / episodes);
    CHECK(std::abs(guessed - chance) <= std::max(0.15, sampling));
  }
}

TEST_CASE("Oracles solve some variants, and guesses are right by chance", "[variants]") {
  check_solved(sample(16, 200));
}

TEST_CASE("Oracles solve variants, and guesses are right by chance", "[variants][long]") {
  check_solved(sample(1, kAnyLength));
}

TEST_CASE("The ids of the example file are solved", "[variants]") {
  const std::size_t before = all_entries().size();
  load_variants(std::string(test::kRoot) + "/apps/examples/medium_variants.json");
  const std::vector<const RegistryEntry*> entries = all_entries();
  REQUIRE(entries.size() == before + 5);
  for (std::size_t i = before; i < entries.size(); ++i) {
    INFO(entries[i]->id);
    const test::TriedVariant variant{std::string(entries[i]->id), "{}"};
    CHECK(success(variant, Policy::kOracle, 20) >= 0.95);
  }
}

void check_images(const std::vector<test::TriedVariant>& variants) {
  for (const test::TriedVariant& variant : variants) {
    INFO(variant.id << " " << variant.json);
    // Objects may be small; and there are many variants.
    test::check_leaks(variant.id, variant.constants(), 0, {.enough = 5, .closely = 8});
  }
}

TEST_CASE("No image of some variants after the cue reveals what was shown", "[variants][render]") {
  check_images(sample(32, 200));
}

TEST_CASE("No image of a variant after the cue reveals what was shown",
          "[variants][render][long]") {
  check_images(sample(8, kAnyLength));  // all of them would take a quarter of an hour
}

}  // namespace
}  // namespace engram
