// Equal seeds give equal bits, whatever the threads, the batch size and the chunks.
#include <catch2/catch.hpp>
#include <cstdint>
#include <initializer_list>
#include <string>
#include <vector>

#include "tasks/family_samples.h"
#include "tests/env_helpers.h"

namespace engram {
namespace {

using test::Bytes, test::make_running;

// Bytes of all environments after every step, environment by environment.
using History = std::vector<std::vector<Bytes>>;

History play(const std::string& id, const BatchOptions& options, Policy policy, int steps) {
  const auto batch = make_running(id, options);
  History history(static_cast<std::size_t>(options.num_envs));
  const auto note = [&] {
    for (int i = 0; i < options.num_envs; ++i) {
      history[static_cast<std::size_t>(i)].push_back(test::env_bytes(*batch, i));
    }
  };
  note();
  for (int i = 0; i < steps; ++i) {
    test::step(*batch, policy);
    note();
  }
  return history;
}

// Past the end of an episode for the short ids.
constexpr int kSteps = 40;

void check_threads_and_chunks(const std::vector<std::string>& ids) {
  for (const std::string& id : ids) {
    for (const Policy policy : {Policy::kRandom, Policy::kOracle}) {
      BatchOptions options{.num_envs = 7, .threads = 1};
      const History reference = play(id, options, policy, kSteps);
      INFO(id);
      CHECK((play(id, options, policy, kSteps) == reference));  // run to run
      for (const int threads : {2, 3, 5}) {
        options.threads = threads;
        options.chunk = threads == 3 ? 2 : 0;
        CHECK((play(id, options, policy, kSteps) == reference));
      }
      options.chunk = 100;
      CHECK((play(id, options, policy, kSteps) == reference));
    }
  }
}

TEST_CASE("Results depend on neither threads nor chunks", "[determinism]") {
  check_threads_and_chunks(one_of_each_family());
}

TEST_CASE("Results of every task depend on neither threads nor chunks", "[determinism][long]") {
  check_threads_and_chunks(test::implemented_ids());
}

// Compares environments of a batch with single ones of their seeds.
void check_singles(const std::string& id, const BatchOptions& options, Policy policy,
                   std::initializer_list<int> indices) {
  const History batch = play(id, options, policy, kSteps);
  INFO(id);
  for (const int index : indices) {
    const BatchOptions single{.seed = options.seed + static_cast<std::uint64_t>(index)};
    const History alone = play(id, single, policy, kSteps);
    CHECK((alone[0] == batch[static_cast<std::size_t>(index)]));
  }
}

void check_singles(const std::vector<std::string>& ids) {
  for (const std::string& id : ids) {
    for (const Policy policy : {Policy::kRandom, Policy::kOracle}) {
      const BatchOptions options{.num_envs = 64, .seed = 100, .threads = 2};
      check_singles(id, options, policy, {0, 5, 31, 63});
    }
  }
}

TEST_CASE("Ranges of more environments than move together change nothing", "[determinism]") {
  const BatchOptions options{.num_envs = 150, .threads = 1, .chunk = 150};
  check_singles("ShellGamePush-VLA-v0", options, Policy::kOracle, {0, 63, 64, 149});
}

TEST_CASE("An environment of a batch equals the single one of its seed", "[determinism]") {
  check_singles(one_of_each_family());
}

TEST_CASE("An environment of a batch of any task equals the single one", "[determinism][long]") {
  check_singles(test::implemented_ids());
}

TEST_CASE("Different seeds give different episodes", "[determinism]") {
  const BatchOptions options{.num_envs = 2};
  const History history = play("RememberColor9-VLA-v0", options, Policy::kZero, 1);
  CHECK((history[0][0] != history[1][0]));
}

}  // namespace
}  // namespace engram
