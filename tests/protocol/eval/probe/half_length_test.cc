#include "protocol/eval/probe/half_length.h"

#include <catch2/catch.hpp>

namespace engram {
namespace {

// The first `right` of ten answers are right.
DelayedAnswers answers(int delay, int right) {
  DelayedAnswers one{delay, std::vector<bool>(10)};
  for (int i = 0; i < right; ++i) one.right[static_cast<std::size_t>(i)] = true;
  return one;
}

TEST_CASE("The half length lies where half of what is above chance is left", "[probe]") {
  CHECK(half_length({answers(0, 10), answers(3, 6), answers(15, 2)}, 0.2).value() == Approx(3));
  CHECK(half_length({answers(0, 10), answers(15, 2)}, 0.2).value() == Approx(3));
}

TEST_CASE("There is no half length without a fall, or without a beginning above chance",
          "[probe]") {
  CHECK_FALSE(half_length({answers(0, 10), answers(15, 7)}, 0.2));
  CHECK_FALSE(half_length({answers(0, 2), answers(15, 0)}, 0.2));
  CHECK(is_null(half_length_document({answers(0, 2), answers(15, 0)}, 0.2)));
  CHECK(is_null(part(half_length_document({answers(0, 10), answers(15, 10)}, 0.2), "steps")));
}

TEST_CASE("The interval of a half length holds it, and is the same in every run", "[probe]") {
  const std::vector<DelayedAnswers> curve = {answers(1, 10), answers(10, 7), answers(100, 3)};
  const Json document = half_length_document(curve, 0.2);
  const double steps = number(part(document, "steps"));
  const JsonList& interval = list(part(document, "interval"));
  CHECK(number(interval.at(0)) < steps);
  CHECK((is_null(interval.at(1)) || number(interval.at(1)) > steps));
  CHECK(to_text(half_length_document(curve, 0.2)) == to_text(document));
}

}  // namespace
}  // namespace engram
