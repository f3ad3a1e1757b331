// First answers, and what a policy without memory achieves where the first answer decides.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <string>
#include <vector>

#include "tests/env_helpers.h"

namespace engram {
namespace {

using test::make_env, test::make_running, test::row;

// Shares of episodes.
struct Outcome {
  double success = 0;
  double answered = 0;
  double correct = 0;  // first answers
};

Outcome play(const std::string& id, Policy policy, bool strict, int episodes) {
  BatchOptions options{.num_envs = episodes};
  options.seed = 77'000;
  options.threads = 2;
  options.auto_reset = AutoReset::kOff;
  if (strict) options.task_options = {{kStrictOption, 1}};
  const auto batch = make_running(id, options);
  const auto& finished = batch->state().finished;
  while (std::any_of(finished.data(), finished.data() + episodes,
                     [](std::uint8_t over) { return over == 0; })) {
    test::step(*batch, policy);
  }
  Outcome outcome;
  for (int i = 0; i < episodes; ++i) {
    outcome.success += *row<std::uint8_t>(batch->output("success_once"), i);
    outcome.answered += *row<std::uint8_t>(batch->output("answered"), i);
    outcome.correct += *row<std::uint8_t>(batch->output("first_answer_correct"), i);
  }
  outcome.success /= episodes;
  outcome.answered /= episodes;
  outcome.correct /= episodes;
  return outcome;
}

bool is_lengthy(const RegistryEntry& entry) { return entry.horizon > 300; }

bool asks(const std::string& id) { return !make_task(id)->info().answer.empty(); }

// The tasks that ask for answers, one or all of every family.
std::vector<std::string> asking(bool lengthy) {
  std::vector<std::string> ids;
  for (const std::string& id : test::implemented_ids()) {
    if (is_lengthy(require_entry(id)) == lengthy && asks(id)) ids.push_back(id);
  }
  return ids;
}

// The largest share of episodes that luck explains: more than that comes once in ten thousand
// tries.
double by_luck(double chance, int episodes) {
  if (chance >= 1) return 1;
  double exactly = std::pow(1 - chance, episodes);  // that many right answers
  double at_most = exactly;
  int right = 0;
  while (at_most < 1 - 1e-4 && right < episodes) {
    exactly *= (episodes - right) * chance / ((right + 1) * (1 - chance));
    at_most += exactly;
    ++right;
  }
  return static_cast<double>(right) / episodes;
}

// Tasks whose answers need no memory at all, by their rules (docs/memory.md): in TimedTransfer the
// signal comes at nearly the same step in every episode, in Blink the cue is the longer the more
// blinks it has, where there is one cube the flash is still lit when the button is pressed, and
// batteries can be tested in a fixed order, pegs turned at an even pace, by the clock.
bool needs_no_memory(std::string_view id) {
  return id.starts_with("TimedTransfer") || id.starts_with("BlinkCount") ||
         id.starts_with("GatherAndRecall1") || id.starts_with("Batteries") ||
         id.starts_with("Rotate");
}

void check_strictness(const std::string& id, int most) {
  const RegistryEntry& entry = require_entry(id);
  const int episodes = std::clamp(40'000 / entry.horizon, 20, most);
  const double chance = make_task(id)->info().answer_chance();
  INFO(id << ", chance of an answer " << chance);
  const Outcome oracle = play(id, Policy::kOracle, true, episodes);
  CHECK(oracle.success >= entry.oracle_floor);
  CHECK(oracle.correct >= oracle.success);
  for (const Policy policy : {Policy::kBlind, Policy::kSweep}) {
    INFO(name_of(policy));
    const Outcome outcome = play(id, policy, true, episodes);
    if (policy == Policy::kSweep && needs_no_memory(id)) {
      CHECK(outcome.success > chance);
      continue;
    }
    CHECK(outcome.success <= by_luck(chance, episodes));
    CHECK(outcome.correct <= by_luck(chance, episodes));
    CHECK(outcome.success <= outcome.correct);
  }
}

TEST_CASE("Where the first answer decides, only memory helps", "[answer]") {
  for (const std::string& id : asking(false)) check_strictness(id, 20);
}

TEST_CASE("Where the first answer decides, only memory helps in long tasks, too",
          "[answer][long]") {
  for (const bool lengthy : {false, true}) {
    for (const std::string& id : asking(lengthy)) check_strictness(id, 40);
  }
}

TEST_CASE("All tasks ask for answers but those that hide nothing", "[answer]") {
  for (const std::string& id : test::implemented_ids()) {
    INFO(id);
    CHECK(asks(id) == (id.find("Intercept") == std::string::npos));
  }
}

TEST_CASE("Strictness changes nothing while first answers are right", "[answer]") {
  for (const char* id : {"RememberColor3-VLA-v0", "RememberShape9-VLA-v0"}) {
    BatchOptions options{.num_envs = 16};
    const auto usual = make_env(id, options);
    options.task_options = {{kStrictOption, 1}};
    const auto strict = make_env(id, options);
    usual->reset();
    strict->reset();
    for (int t = 0; t < usual->info().horizon - 1; ++t) {
      test::step(*usual, Policy::kOracle);
      test::step(*strict, Policy::kOracle);
      REQUIRE(test::batch_bytes(*usual) == test::batch_bytes(*strict));
    }
  }
}

// A robot that answers wrongly first and rightly afterwards.
TEST_CASE("A wrong first answer fails a strict episode for good", "[answer]") {
  for (const bool strict : {false, true}) {
    const auto batch = make_running("RememberColor9-Long-VLA-v0",
                                    {.num_envs = 64,
                                     .auto_reset = AutoReset::kOff,
                                     .task_options = {{kStrictOption, strict ? 1.0 : 0.0}}});
    const auto flag = [&](const char* name, int i) {
      return *row<std::uint8_t>(batch->output(name), i) != 0;
    };
    int wrong = 0;
    int recovered = 0;
    for (int t = 0; t < batch->info().horizon; ++t) {
      test::step(*batch, Policy::kSweep);
      for (int i = 0; i < batch->num_envs(); ++i) {
        if (!flag("answered", i) || flag("first_answer_correct", i)) continue;
        CHECK(flag("failed", i) == strict);
        wrong += batch->state().elapsed[i] == batch->info().horizon ? 1 : 0;
        recovered += flag("success", i) ? 1 : 0;
      }
    }
    CHECK(wrong > 40);
    CHECK((recovered > 0) == !strict);
  }
}

TEST_CASE("Nobody has answered before there is anything to answer", "[answer]") {
  for (const std::string& id : asking(false)) {
    const auto batch = make_running(id, {.num_envs = 8});
    INFO(id);
    for (int i = 0; i < batch->num_envs(); ++i) {
      CHECK(*row<std::uint8_t>(batch->output("answered"), i) == 0);
      CHECK(*row<std::uint8_t>(batch->output("first_answer_correct"), i) == 0);
    }
  }
}

}  // namespace
}  // namespace engram
