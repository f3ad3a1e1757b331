// Answers to questions: what is taken, and what is refused.
#include "protocol/eval/policies/choice_question.h"

#include <catch2/catch.hpp>

#include "core/base/error.h"

namespace engram {
namespace {

ChoiceQuestion question_of(const ChoiceForm& form) {
  ChoiceQuestion question;
  question.form = form;
  question.choices = {"the red cube", "the green cube", "the blue cube"};
  return question;
}

using Words = std::vector<std::string>;
using Indices = std::vector<int>;

Indices indices_of(const ChoiceAnswer& answer) {
  return {answer.indices().begin(), answer.indices().end()};
}

TEST_CASE("A choice is named by its text or its index", "[choices]") {
  const ChoiceQuestion question = question_of({});
  ChoiceAnswer answer(question);
  CHECK_THROWS_WITH(answer.indices(), "policy: no choice given");
  answer.set(Words{"the blue cube"});
  CHECK(indices_of(answer) == Indices{2});
  answer.set(Words{"1"});
  CHECK(indices_of(answer) == Indices{1});
  answer.set(Indices{0});
  CHECK(indices_of(answer) == Indices{0});
}

TEST_CASE("Answers of another form are refused and change nothing", "[choices]") {
  const ChoiceQuestion question = question_of({});
  ChoiceAnswer answer(question);
  answer.set(Indices{1});
  CHECK_THROWS_WITH(answer.set(Words{"the pink cube"}),
                    "policy: choice 'the pink cube' given, the red cube, the green cube, the blue "
                    "cube, or an index, allowed");
  for (const char* text : {"", "The red cube", " 1", "1 ", "1.0", "-1", "99999999999"}) {
    CHECK_THROWS_WITH(answer.set(Words{text}),
                      Catch::StartsWith(std::string("policy: choice '") + text + "' given, the"));
  }
  CHECK_THROWS_WITH(answer.set(Words{"3"}), "policy: choice 3 given, 0 to 2 allowed");
  CHECK_THROWS_WITH(answer.set(Indices{-1}), "policy: choice -1 given, 0 to 2 allowed");
  CHECK_THROWS_WITH(answer.set(Indices{}), "policy: 0 choices given, 1 needed");
  CHECK_THROWS_WITH(answer.set(Indices{0, 1}), "policy: 2 choices given, 1 needed");
  CHECK(indices_of(answer) == Indices{1});
}

TEST_CASE("A list of choices has its length and, if need be, no item twice", "[choices]") {
  const ChoiceQuestion set = question_of({.least = 2, .most = 2});
  ChoiceAnswer of_set(set);
  of_set.set(Words{"the blue cube", "0"});
  CHECK(indices_of(of_set) == Indices{2, 0});
  CHECK_THROWS_WITH(of_set.set(Indices{1, 1}), "policy: choice 1 given twice, once allowed");

  const ChoiceQuestion sequence = question_of({.least = 1, .most = 4, .repeats = true});
  ChoiceAnswer of_sequence(sequence);
  of_sequence.set(Indices{1, 1, 0, 1});
  CHECK(indices_of(of_sequence) == Indices{1, 1, 0, 1});
  CHECK_THROWS_WITH(of_sequence.set(Indices{1, 1, 0, 1, 2}),
                    "policy: 5 choices given, 1 to 4 needed");
}

TEST_CASE("Refused texts are shown without control characters, and shortened", "[choices]") {
  const ChoiceQuestion question = question_of({});
  ChoiceAnswer answer(question);
  CHECK_THROWS_WITH(answer.set(Words{"\x1b[31m" + std::string(5000, 'x')}),
                    Catch::StartsWith("policy: choice '\\u001b[31mxxx"));
  try {
    answer.set(Words{std::string(5000, 'x')});
  } catch (const Error& error) {
    CHECK(std::string(error.what()).size() < 400);
  }
}

}  // namespace
}  // namespace engram
