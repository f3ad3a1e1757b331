#include "core/task/answers.h"

#include <catch2/catch.hpp>

namespace engram {
namespace {

TEST_CASE("The first answer of an episode counts", "[answers]") {
  ColumnStore outputs(2);
  Answers answers;
  answers.bind(outputs);
  for (int env = 0; env < 2; ++env) outputs.clear_row(env);
  CHECK_FALSE(answers.given(0));
  CHECK_FALSE(answers.wrong(0));
  answers.give(0, 3, false);
  answers.give(0, 1, true);
  CHECK(answers.given(0));
  CHECK(answers.wrong(0));
  CHECK_FALSE(answers.given(1));
  const auto value = [&](const char* name) {
    return *reinterpret_cast<const std::int32_t*>(outputs.find(name).row(0));
  };
  CHECK(value("first_answer") == 3);
  answers.give(1, 2, true);
  CHECK(answers.given(1));
  CHECK_FALSE(answers.wrong(1));
}

}  // namespace
}  // namespace engram
