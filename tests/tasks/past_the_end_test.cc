// Environments that are simulated on after their episode's end, and horizons of users' own.
#include <algorithm>
#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "tasks/family_samples.h"
#include "tests/env_helpers.h"

namespace engram {
namespace {

using test::batch_bytes, test::Bytes, test::make_env;

MakeOptions going_on(int threads = 1) {
  MakeOptions options;
  options.num_envs = 3;
  options.threads = threads;
  options.seed = 11;
  options.auto_reset = AutoReset::kOff;
  options.after_end = AfterEnd::kContinue;
  return options;
}

// Whether everything that the batch shows is as it must be after N steps.
bool is_in_order(const Batch& batch, int steps) {
  bool good = true;
  for (int i = 0; i < batch.num_envs(); ++i) {
    const auto at = static_cast<std::size_t>(i);
    good &= *test::row<std::int32_t>(batch.output("elapsed_steps"), i) == steps;
    good &= batch.outputs().truncated[at] == (steps >= batch.info().horizon ? 1 : 0);
    good &= batch.outputs().unstable[at] == 0;
  }
  return good;
}

Bytes play(Batch& batch, Policy policy, int steps) {
  batch.reset();
  bool good = true;
  for (int i = 1; i <= steps; ++i) {
    test::step(batch, policy);
    good &= is_in_order(batch, i);
  }
  CHECK(good);
  return batch_bytes(batch);
}

void check_going_on(const std::vector<std::string>& ids) {
  for (const std::string& id : ids) {
    CAPTURE(id);
    const auto one = make_env(id, going_on(1));
    const auto three = make_env(id, going_on(3));
    const int steps = 2 * one->info().horizon;
    CHECK(play(*one, Policy::kOracle, steps) == play(*three, Policy::kOracle, steps));
  }
}

TEST_CASE("Short tasks go on for twice their horizon, whatever the threads", "[past_the_end]") {
  check_going_on(short_ids());
}

TEST_CASE("Every task goes on for twice its horizon, whatever the threads",
          "[past_the_end][long]") {
  check_going_on(test::implemented_ids());
}

// Without physics, so that there is time for every policy.
TEST_CASE("Every policy goes on after the end of every task", "[past_the_end]") {
  for (const std::string& id : test::implemented_ids()) {
    CAPTURE(id);
    MakeOptions options = going_on();
    options.num_envs = 2;
    options.substeps = 0;
    options.terminate_on_success = false;
    options.terminate_on_failure = false;
    const auto batch = make_env(id, options);
    for (const Policy policy : {Policy::kBlind, Policy::kSweep}) {
      play(*batch, policy, batch->info().horizon + 100);
      CHECK(std::ranges::max(batch->outputs().terminated) == 0);
    }
  }
}

TEST_CASE("Every task can be truncated at any time", "[past_the_end]") {
  for (const std::string& id : test::implemented_ids()) {
    CAPTURE(id);
    const int own = make_env(id)->info().horizon;
    MakeOptions options = going_on();
    options.num_envs = 1;
    options.substeps = 0;
    for (const int steps : {1, 5, own + 10}) {
      options.max_episode_steps = steps;
      const auto batch = make_env(id, options);
      CHECK(batch->info().horizon == steps);
      for (const Policy policy : {Policy::kOracle, Policy::kSweep}) {
        play(*batch, policy, std::min(steps, 20));
      }
    }
  }
}

}  // namespace
}  // namespace engram
