#include "protocol/eval/probe/answers.h"

#include <catch2/catch.hpp>

namespace engram {
namespace {

TrialResult answer(std::int32_t number, bool correct = false) {
  return {.answered = 1, .correct = correct ? std::uint8_t{1} : std::uint8_t{0}, .answer = number};
}

}  // namespace

TEST_CASE("Answers in any order are the same with the same digits", "[probe]") {
  CHECK(same_answer(answer(132), answer(213), true));
  CHECK_FALSE(same_answer(answer(132), answer(213), false));
  CHECK_FALSE(same_answer(answer(132), answer(133), true));
  CHECK_FALSE(same_answer(answer(0), {}, true));
}

TEST_CASE("An answer that another scene cuts short is as in its own scene up to there", "[probe]") {
  const TrialResult own = answer(472, true);
  CHECK(answers_as(answer(472), own, AnswerCut::kDigits));
  CHECK(answers_as(answer(47), own, AnswerCut::kDigits));
  CHECK(answers_as(answer(4), own, AnswerCut::kDigits));
  CHECK_FALSE(answers_as(answer(42), own, AnswerCut::kDigits));
  CHECK_FALSE(answers_as(answer(4723), own, AnswerCut::kDigits));
  CHECK_FALSE(answers_as({}, own, AnswerCut::kDigits));
  // Where an answer has one part, 4 is another one.
  CHECK_FALSE(answers_as(answer(4), own, AnswerCut::kNone));
}

TEST_CASE("A count that another scene cuts short is below that of its own scene", "[probe]") {
  const TrialResult own = answer(4, true);
  CHECK(answers_as(answer(4), own, AnswerCut::kCount));
  CHECK(answers_as(answer(3), own, AnswerCut::kCount));
  CHECK_FALSE(answers_as(answer(5), own, AnswerCut::kCount));
}

TEST_CASE("What is right in the other scene was not cut short", "[probe]") {
  CHECK_FALSE(answers_as(answer(4, true), answer(472, true), AnswerCut::kDigits));
  CHECK_FALSE(answers_as(answer(3, true), answer(4, true), AnswerCut::kCount));
}

}  // namespace engram
