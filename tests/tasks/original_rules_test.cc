// rules=original: every option of every task is what the original's code has, unless a user says
// more.
#include <algorithm>
#include <catch2/catch.hpp>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "core/batch/queries.h"
#include "core/batch/snapshot.h"
#include "tests/env_helpers.h"

namespace engram {
namespace {

using test::make_env, test::make_running;

struct OptionUnderRules {
  double reference;
  double original;
};

// What docs/physics.md says of them. An option that is not here is one that nobody has thought
// about: has the original's code another value?
const std::map<std::string, OptionUnderRules> kKnown = {
    {"touch_radius", {0.05, 0.02}},
    {"strict_order", {0, 1}},
    {"repeated_touches", {0, 1}},
    {"fixed_mapping", {0, 1}},
    {"snap_back", {0, 1}},
    {"success_in_cue", {0, 1}},
    {"static_needed", {0, 1}},
    {"mug_at_goal", {0, 1}},
    {"upstream_handle", {0, 1}},
    {"may_overlap", {0, 1}},
    {"red_pushes_green", {0, 1}},
    {"check_all", {0, 1}},
    {"upstream_rewards", {0, 1}},
    {"socket_battery_idx", {-1, 0}},
    {"truncate_window", {0, 1}},
    // Not departures.
    {"strict", {0, 0}},
    {"blink_red", {0, 0}},
    {"blink_green", {0, 0}},
    {"blink_blue", {1, 1}},
};

// Families that have a departure to switch, by option.
const std::map<std::string, std::set<std::string>> kFamilies = {
    {"touch_radius", {"BunchOfColors", "SeqOfColors", "ChainOfColors"}},
    {"strict_order", {"SeqOfColors"}},
    {"repeated_touches", {"ChainOfColors"}},
    {"fixed_mapping", {"ShellGameColorLampTouch", "ShellGameShuffleColorLampTouch"}},
    {"snap_back", {"ShellGameShuffleTouch", "ShellGameShuffleColorLampTouch"}},
    {"success_in_cue", {"RememberColor", "RememberShape", "RememberShapeAndColor"}},
    {"static_needed", {"FindImposterColor", "FindImposterShape", "FindImposterShapeAndColor"}},
    {"mug_at_goal", {"ShellGamePush", "ShellGamePick"}},
    {"upstream_handle", {"ShellGamePick"}},
    {"may_overlap", {"TakeItBack"}},
    {"red_pushes_green", {"TraceShape", "TraceShapeSeq"}},
    {"check_all", {"BatteriesCheckerEasy", "BatteriesCheckerHard"}},
    {"upstream_rewards", {"BatteriesCheckerEasy", "BatteriesCheckerHard"}},
    {"socket_battery_idx", {"BatteriesCheckerEasy", "BatteriesCheckerHard"}},
    {"truncate_window", {"TimedTransfer"}},
};

OptionUnderRules known_of(const std::string& id, const std::string& option) {
  // In the RL tasks this is no departure.
  const bool rl = require_entry(id).split == Split::kRl;
  if (rl && option == "touch_radius") return {0.02, 0.02};
  return kKnown.at(option);
}

BatchOptions under(Rules rules, std::vector<TaskOptionValue> choices = {}) {
  BatchOptions options{.task_options = std::move(choices), .rules = rules};
  return options;
}

std::vector<double> values(const Batch& batch) {
  return {Queries(batch).option_values().begin(), Queries(batch).option_values().end()};
}

TEST_CASE("Both rules set every option of every task as documented", "[rules]") {
  std::map<std::string, std::set<std::string>> families;
  for (const std::string& id : test::implemented_ids()) {
    INFO(id);
    const std::unique_ptr<Task> task = make_task(id);
    const std::vector<TaskOptionSpec>& options = task->info().options;
    if (options.empty()) continue;
    const std::vector<double> reference = values(*make_env(id, under(Rules::kReference)));
    const std::vector<double> original = values(*make_env(id, under(Rules::kOriginal)));
    REQUIRE(reference.size() == options.size());
    REQUIRE(original.size() == options.size());
    for (std::size_t i = 0; i < options.size(); ++i) {
      INFO(options[i].name);
      REQUIRE(kKnown.contains(options[i].name));
      const OptionUnderRules known = known_of(id, options[i].name);
      CHECK(reference[i] == known.reference);
      CHECK(original[i] == known.original);
      CHECK(options[i].original.has_value() == (known.original != known.reference));
      CHECK(original[i] >= options[i].low);
      CHECK(original[i] <= options[i].high);
      if (options[i].original) families[options[i].name].insert(task->info().family);
    }
  }
  CHECK(families == kFamilies);
}

// touch_radius, strict_order, strict.
TEST_CASE("Rules without a word are the reference's", "[rules]") {
  CHECK(BatchOptions().rules == Rules::kReference);
  CHECK(values(*make_env("SeqOfColors3-VLA-v0")) == std::vector<double>{0.05, 0, 0});
}

TEST_CASE("What a user says of an option wins over the rules", "[rules]") {
  const auto chosen = [](Rules rules, const std::vector<TaskOptionValue>& choices) {
    return values(*make_env("SeqOfColors3-VLA-v0", under(rules, choices)));
  };
  CHECK(chosen(Rules::kOriginal, {}) == std::vector<double>{0.02, 1, 0});
  CHECK(chosen(Rules::kOriginal, {{"touch_radius", 0.03}}) == std::vector<double>{0.03, 1, 0});
  CHECK(chosen(Rules::kOriginal, {{"strict_order", 0}}) == std::vector<double>{0.02, 0, 0});
  // The reference's own value, too.
  CHECK(chosen(Rules::kOriginal, {{"touch_radius", 0.05}}) == std::vector<double>{0.05, 1, 0});
  CHECK(chosen(Rules::kReference, {{"strict_order", 1}}) == std::vector<double>{0.05, 1, 0});
}

// Without a departure to switch, the rules are the same.
TEST_CASE("Rules do not touch tasks without such an option", "[rules]") {
  for (const char* id : {"RotateLenientPos-VLA-v0", "BlinkCountButtonPressEasy-VLA-v0"}) {
    INFO(id);
    std::vector<test::Bytes> played;
    for (const Rules rules : {Rules::kReference, Rules::kOriginal}) {
      const auto batch = make_running(id, under(rules));
      for (int i = 0; i < 20; ++i) test::step(*batch, Policy::kOracle);
      played.push_back(test::batch_bytes(*batch));
    }
    CHECK((played[0] == played[1]));
  }
}

TEST_CASE("Snapshots of other rules are refused by name", "[rules][snapshot]") {
  for (const char* id : {"SeqOfColors3-VLA-v0", "RotateLenientPos-VLA-v0"}) {
    INFO(id);
    const auto reference = make_env(id, under(Rules::kReference));
    const auto original = make_env(id, under(Rules::kOriginal));
    reference->reset();
    original->reset();
    const test::Bytes before = test::env_bytes(*original, 0);
    CHECK_THROWS_WITH(Snapshotter(*original).restore(Snapshotter(*reference).save()),
                      Catch::Contains("it is of " + std::string(id)) &&
                          Catch::Contains("rules=reference") &&
                          Catch::Contains("; this batch is of " + std::string(id)) &&
                          Catch::Contains("rules=original"));
    CHECK_THROWS_WITH(Snapshotter(*reference).restore(0, Snapshotter(*original).save(0)),
                      Catch::Contains("rules=original"));
    CHECK((test::env_bytes(*original, 0) == before));
    const auto another = make_env(id, under(Rules::kOriginal));
    Snapshotter(*another).restore(Snapshotter(*original).save());
    CHECK((test::env_bytes(*another, 0) == before));
  }
}

}  // namespace
}  // namespace engram
