// Policies that name answers: what they are asked, and that a hand carries out what they name.
#include "protocol/eval/policies/choosing_policy.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <iterator>
#include <map>
#include <numeric>
#include <set>

#include "core/math/random.h"
#include "tests/protocol/eval/policies/choice_play.h"

namespace engram {
namespace {

using test::ChoicePlay, test::play_choices;

// Fewer episodes where they are long.
int affordable(const std::string& id, int episodes) {
  constexpr int kSteps = 50'000;
  return std::clamp(kSteps / require_entry(id).horizon, 10, episodes);
}

void tell_right(const Batch& batch, const ChoiceQuestion& question, ChoiceAnswer& answer) {
  INFO(question.env_id << ", step " << question.step);
  const std::vector<std::string> right = test::right_answer(batch, question);
  REQUIRE(!right.empty());
  for (const std::string& item : right) {
    CHECK(std::ranges::find(question.choices, item) != question.choices.end());
  }
  answer.set(right);
}

// Uniform over the lengths of answers, then over the items.
void guess(const Batch& /*env*/, const ChoiceQuestion& question, ChoiceAnswer& answer) {
  RandomStream random(static_cast<std::uint64_t>(question.number),
                      static_cast<std::uint64_t>(question.index), 7);
  std::vector<int> order(question.choices.size());
  const int length = random.integer(question.form.least, question.form.most);
  if (question.form.repeats) {
    std::ranges::generate(order,
                          [&] { return random.integer(0, static_cast<int>(order.size()) - 1); });
    std::vector<int> items;
    for (int i = 0; i < length; ++i) {
      items.push_back(random.integer(0, static_cast<int>(order.size()) - 1));
    }
    answer.set(items);
    return;
  }
  random.permutation(order);
  answer.set(std::span(order).first(static_cast<std::size_t>(length)));
}

void check_right_answers(bool lengthy) {
  for (const std::string& id : test::ids_with_choices()) {
    const RegistryEntry& entry = require_entry(id);
    if (test::is_lengthy(entry) != lengthy) continue;
    const auto told = play_choices({.id = id, .episodes = affordable(id, 50)}, tell_right);
    INFO(id);
    CHECK(told.rate() >= entry.oracle_floor);
    CHECK(told.answer_rate() >= entry.oracle_floor);
  }
}

TEST_CASE("The hand does what the oracle does if the right answer is named", "[choices]") {
  check_right_answers(false);
}

TEST_CASE("The hand does so in long tasks, too", "[choices][long]") { check_right_answers(true); }

// --- guessing ---

void check_guesses(bool lengthy, int most) {
  for (const std::string& id : test::ids_with_choices()) {
    const RegistryEntry& entry = require_entry(id);
    if (test::is_lengthy(entry) != lengthy) continue;
    const int episodes = affordable(id, most);
    const std::unique_ptr<Task> task = make_task(id);
    const double estimated = answer_controller_of(*task)->choice_chance();
    const auto outcome = play_choices({.id = id, .episodes = episodes}, guess);
    INFO(id);
    const auto check = [episodes](double rate, double chance, double model_error) {
      const double sigma = std::sqrt(chance * (1 - chance) / episodes);
      INFO(rate << " of " << episodes << ", chance " << chance);
      CHECK(std::abs(rate - chance) <= 4 * sigma + 1.0 / episodes + model_error);
    };
    check(outcome.answer_rate(), task->info().answer_chance(), 0);
    // A moving point stands for the cube in estimates.
    if (estimated > 0) check(outcome.rate(), estimated, 0.05);
    if (estimated == 0) check(outcome.rate(), task->info().chance(), 0);
  }
}

TEST_CASE("Uniform guesses among the choices are right by chance", "[choices]") {
  check_guesses(false, 40);
}

TEST_CASE("Uniform guesses are right by chance in long tasks, too", "[choices][long]") {
  check_guesses(false, 100);
  check_guesses(true, 100);
}

// --- the list ---

// Plays an episode up to its first question, and returns that.
struct FirstQuestion {
  std::vector<std::string> choices;
  std::vector<std::string> right;
};

FirstQuestion ask_first(const std::string& id, std::uint64_t seed, const std::vector<Pin>& pins) {
  MakeOptions options;
  options.threads = 1;
  options.auto_reset = AutoReset::kOff;
  options.seed = seed;
  options.pins = pins;
  const std::unique_ptr<Batch> batch = make(id, options);
  batch->reset();
  const std::atomic<bool> stopped = false;
  std::atomic<std::uint64_t> steps = 0;
  const WorkContext context(0, stopped, steps);
  FirstQuestion first;
  test::Chooser chooser([&](const ChoiceQuestion& question, ChoiceAnswer& answer) {
    first = {question.choices, test::right_answer(*batch, question)};
    std::vector<int> any(static_cast<std::size_t>(question.form.least));
    if (!question.form.repeats) std::iota(any.begin(), any.end(), 0);
    answer.set(any);
  });
  ChoosingPolicy policy(*batch, chooser, context, {});
  policy.start(0, {0, 0, seed});
  std::vector<float> actions(static_cast<std::size_t>(batch->action_dim()));
  std::vector<std::uint8_t> commanded(1);
  while (first.choices.empty() &&
         (batch->outputs().terminated[0] | batch->outputs().truncated[0]) == 0) {
    policy.act(actions, commanded);
    batch->step(actions);
  }
  REQUIRE(!first.choices.empty());
  return first;
}

std::vector<double> extreme_values(const RandomVariable& draw, bool most) {
  std::vector<double> values(static_cast<std::size_t>(draw.width), most ? draw.high : draw.low);
  for (std::size_t i = 0; draw.distinct && i < values.size(); ++i) {
    values[i] += (most ? -1.0 : 1.0) * static_cast<double>(i);
  }
  return values;
}

void check_lists(bool lengthy) {
  int compared = 0;
  for (const std::string& id : test::ids_with_choices()) {
    if (test::is_lengthy(require_entry(id)) != lengthy) continue;
    const std::unique_ptr<Task> task = make_task(id);
    const auto& draws = task->info().random_variables;
    const auto hidden =
        std::ranges::find(draws, task->info().hidden_variable, &RandomVariable::name);
    if (hidden == draws.end()) continue;
    INFO(id);
    const FirstQuestion low = ask_first(id, 3, {{hidden->name, extreme_values(*hidden, false)}});
    const FirstQuestion high = ask_first(id, 3, {{hidden->name, extreme_values(*hidden, true)}});
    CHECK(low.choices == high.choices);
    const std::set<std::string> different(low.choices.begin(), low.choices.end());
    CHECK(different.size() == low.choices.size());
    // One shape of several sizes; batteries in any order.
    const bool differs = low.choices.size() > 1 && !id.starts_with("Batteries");
    CHECK((low.right != high.right) == differs);
    ++compared;
  }
  CHECK(compared > 20);
}

TEST_CASE("The list of choices is the same whatever is hidden", "[choices]") { check_lists(false); }

TEST_CASE("The list of choices is the same whatever long tasks hide", "[choices][long]") {
  check_lists(true);
}

TEST_CASE("The right answer is at every place of the list equally often", "[choices]") {
  for (const char* id : {"RememberColor3-VLA-v0", "FindImposterShape5-VLA-v0",
                         "ShellGameShuffleTouch-VLA-v0", "TakeItBack-VLA-v0"}) {
    constexpr int kEpisodes = 300;
    std::vector<int> places;
    const auto note = [&](const Batch& batch, const ChoiceQuestion& question,
                          ChoiceAnswer& answer) {
      const std::vector<std::string> right = test::right_answer(batch, question);
      REQUIRE(right.size() == 1);
      places.resize(question.choices.size());
      ++places[static_cast<std::size_t>(std::ranges::find(question.choices, right[0]) -
                                        question.choices.begin())];
      answer.set(right);
    };
    (void)play_choices({.id = id, .episodes = kEpisodes}, note);
    const double expected = kEpisodes / static_cast<double>(places.size());
    double chi_squared = 0;
    for (const int count : places) chi_squared += std::pow(count - expected, 2) / expected;
    INFO(id);
    CHECK(chi_squared < 16);  // of 2 to 4 degrees of freedom: exceeded once in 300 tests or less
  }
}

// --- frames ---

TEST_CASE("A question has the frames since the episode began", "[choices]") {
  int questions = 0;
  const auto check = [&](const Batch& batch, const ChoiceQuestion& question, ChoiceAnswer& answer) {
    ++questions;
    REQUIRE(!question.steps.empty());
    CHECK(question.steps.front() == 0);
    CHECK(question.steps.back() == question.step);
    CHECK(question.step == batch.state().elapsed[question.slot]);
    CHECK(std::ranges::is_sorted(question.steps));
    REQUIRE(question.texts.size() == question.steps.size());
    CHECK(question.state.size() ==
          question.steps.size() * static_cast<std::size_t>(question.state_dim));
    CHECK(question.proprio.size() == 7 * question.steps.size());
    CHECK(question.rgb.empty());
    for (std::size_t i = 1; i + 1 < question.texts.size(); ++i) {
      CHECK(question.texts[i] != question.texts[i - 1]);
    }
    // The cue shows the cube that is asked for, the pause none, and then all are there.
    const std::string right = test::right_answer(batch, question).at(0).substr(4);
    CHECK_THAT(question.texts.front(), Catch::Contains("; " + right + " at x"));
    CHECK_THAT(question.texts.front(), Catch::Contains("2 objects hidden"));
    CHECK_THAT(question.texts.back(), !Catch::Contains("hidden"));
    CHECK(std::ranges::any_of(question.texts, [](const std::string& text) {
      return text.find("3 objects hidden") != std::string::npos;
    }));
    CHECK(question.instruction == Queries(batch).instruction(question.slot));
    answer.set(std::vector<int>{0});
  };
  (void)play_choices({.id = "RememberColor3-VLA-v0", .episodes = 5, .obs_mode = ObsMode::kObjects},
                     check);
  CHECK(questions == 5);
}

TEST_CASE("Frames are as far apart as the stride says, and the last one is of now", "[choices]") {
  const auto check = [&](const Batch& /*env*/, const ChoiceQuestion& question,
                         ChoiceAnswer& answer) {
    for (std::size_t i = 0; i + 1 < question.steps.size(); ++i) CHECK(question.steps[i] % 4 == 0);
    CHECK(question.steps.back() == question.step);
    answer.set(std::vector<int>{0});
  };
  (void)play_choices(
      {.id = "RememberColor3-VLA-v0", .episodes = 3, .obs_mode = ObsMode::kState, .stride = 4},
      check);
}

TEST_CASE("A task that asks again gives every frame once", "[choices]") {
  std::map<int, std::vector<int>> steps;
  std::map<int, int> questions;
  const auto check = [&](const Batch& batch, const ChoiceQuestion& question, ChoiceAnswer& answer) {
    CHECK(question.index == questions[question.slot]++);
    std::ranges::copy(question.steps, std::back_inserter(steps[question.slot]));
    answer.set(test::right_answer(batch, question));
  };
  const auto outcome = play_choices(
      {.id = "BatteriesCheckerEasy-6-VLA-v0", .episodes = 4, .obs_mode = ObsMode::kObjects}, check);
  CHECK(outcome.rate() == 1);
  for (auto& [env, all] : steps) {
    CHECK(questions[env] > 2);
    CHECK(std::ranges::adjacent_find(all, std::greater_equal<>()) == all.end());
  }
}

// --- results ---

TEST_CASE("Choices do not depend on threads and the size of the batch", "[choices]") {
  for (const char* id : {"ShellGameTouch-VLA-v0", "BatteriesCheckerEasy-3-VLA-v0"}) {
    const auto digests_of = [id](int num_envs, int threads) {
      const auto outcome = play_choices({.id = id,
                                         .episodes = 5,
                                         .num_envs = num_envs,
                                         .threads = threads,
                                         .obs_mode = ObsMode::kObjects},
                                        guess);
      std::vector<std::uint64_t> all;
      for (const EpisodeDigests& digests : outcome.digests) {
        for (const auto& [name, field] : kDigestKeys) all.push_back(digests.*field);
      }
      std::ranges::copy(outcome.successes, std::back_inserter(all));
      return all;
    };
    const auto expected = digests_of(5, 1);
    CHECK(digests_of(1, 1) == expected);
    CHECK(digests_of(3, 2) == expected);
  }
}

}  // namespace
}  // namespace engram
