// Questions of running episodes in the C API.
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/api/c_api_fixture.h"

namespace engram::test {
namespace {

nlohmann::json question_of(engram_env* env, std::int32_t index) {
  std::size_t length = 0;
  REQUIRE(engram_question(env, index, nullptr, 0, &length) == ENGRAM_OK);
  std::string text(length, ' ');
  REQUIRE(engram_question(env, index, text.data(), length + 1, nullptr) == ENGRAM_OK);
  return nlohmann::json::parse(text);
}

// Index of the choice that is right; the words of the first environment say what the cue was.
std::int32_t right_choice(engram_env* env, const nlohmann::json& question) {
  std::string words(2000, ' ');
  REQUIRE(engram_words(env, 0, words.data(), words.size(), nullptr) == ENGRAM_OK);
  for (std::size_t i = 0; i < question["choices"].size(); ++i) {
    const auto name = question["choices"][i].get<std::string>().substr(4);  // after "the "
    if (words.find("the cue was a " + name) != std::string::npos) {
      return static_cast<std::int32_t>(i);
    }
  }
  FAIL(question.dump());
  return -1;
}

// Plays two episodes side by side, of which the first asks, and is answered as the cue was if
// `right`. Returns how often either had success.
std::vector<int> successes(bool right) {
  engram_options options = default_options(2);
  options.auto_reset = ENGRAM_AUTO_RESET_OFF;
  const BatchHandle batch = make_batch(options);
  std::vector<int> count(2);
  for (std::uint64_t seed = 0; seed < 8; ++seed) {
    const std::uint64_t seeds[] = {seed, seed};
    engram_reset_request request{};
    request.seeds = seeds;
    REQUIRE(engram_reset(batch.get(), &request) == ENGRAM_OK);
    REQUIRE(engram_ask(batch.get(), 0) == ENGRAM_OK);
    CHECK_FALSE(question_of(batch.get(), 0)["due"].get<bool>());
    bool asked = false;
    for (int step = 0; step < engram_horizon(batch.get()); ++step) {
      const nlohmann::json question = question_of(batch.get(), 0);
      CHECK_FALSE(question_of(batch.get(), 1)["due"].get<bool>());
      if (question["due"].get<bool>()) {
        CHECK_FALSE(asked);
        asked = true;
        const std::int32_t cue = right_choice(batch.get(), question);
        const std::int32_t choice = right ? cue : (cue + 1) % 3;
        REQUIRE(engram_answer(batch.get(), 0, &choice, 1) == ENGRAM_OK);
      }
      step_by(batch, ENGRAM_POLICY_BLIND);
    }
    CHECK(asked);
    const auto* success = static_cast<const std::uint8_t*>(output(batch, "success_once").data);
    for (std::size_t i = 0; i < 2; ++i) count[i] += success[i];
  }
  return count;
}

TEST_CASE("The blind policy carries out the answer that the caller names", "[c_api][choices]") {
  const std::vector<int> right = successes(true);
  const std::vector<int> wrong = successes(false);
  CHECK(right[0] == 8);
  CHECK(wrong[0] == 0);
  // No answer is awaited in the other environment: it guesses as ever.
  CHECK(right[1] == wrong[1]);
  CHECK(right[1] < 8);
}

TEST_CASE("Questions that are not due, and answers of another form, are refused",
          "[c_api][choices]") {
  const BatchHandle waiting = make_batch(default_options());
  CHECK(engram_ask(waiting.get(), 0) == ENGRAM_BAD_STATE);
  const BatchHandle batch = make_running(1);
  CHECK(engram_ask(batch.get(), 1) == ENGRAM_INVALID_ARGUMENT);
  const std::int32_t answer[] = {0, 3};
  CHECK(engram_answer(batch.get(), 0, answer, 1) == ENGRAM_BAD_STATE);
  REQUIRE(engram_ask(batch.get(), 0) == ENGRAM_OK);
  CHECK(engram_answer(batch.get(), 0, answer, 1) == ENGRAM_BAD_STATE);
  for (int step = 0; !question_of(batch.get(), 0)["due"].get<bool>(); ++step) {
    REQUIRE(step < 25);
    step_by(batch, ENGRAM_POLICY_BLIND);
  }
  CHECK(engram_answer(batch.get(), 0, answer, 2) == ENGRAM_INVALID_ARGUMENT);
  CHECK_THAT(engram_last_error(), Catch::Contains("2 choices given, 1 needed"));
  CHECK(engram_answer(batch.get(), 0, answer + 1, 1) == ENGRAM_INVALID_ARGUMENT);
  CHECK_THAT(engram_last_error(), Catch::Contains("0 to 2 allowed"));
  CHECK(engram_answer(batch.get(), 0, answer, 1) == ENGRAM_OK);
  CHECK(engram_answer(batch.get(), 0, answer, 1) == ENGRAM_BAD_STATE);
}

TEST_CASE("Tasks without a list of answers are not asked", "[c_api][choices]") {
  const BatchHandle batch = make_batch(default_options(1), "InterceptMedium-VLA-v0");
  REQUIRE(engram_reset(batch.get(), nullptr) == ENGRAM_OK);
  CHECK(engram_ask(batch.get(), 0) == ENGRAM_INVALID_ARGUMENT);
  CHECK_THAT(engram_last_error(), Catch::Contains("InterceptMedium-VLA-v0 has no list of answers"));
}

}  // namespace
}  // namespace engram::test
