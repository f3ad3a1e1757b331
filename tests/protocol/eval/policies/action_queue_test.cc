#include "protocol/eval/policies/action_queue.h"

#include <array>
#include <catch2/catch.hpp>

namespace engram {
namespace {

// The next action of one number; -1 where nothing has been commanded.
float next(ActionQueue& queue) {
  std::array<float, 1> action = {-1};
  const bool commanded = queue.next(action);
  CHECK(commanded == (action[0] >= 0));
  return action[0];
}

void answer(ActionQueue& queue, std::vector<float> actions) { queue.answer(actions); }

TEST_CASE("Actions without latency come at once", "[evaluation][latency]") {
  ActionQueue queue;
  CHECK(queue.empty());
  answer(queue, {1, 2});
  CHECK(next(queue) == 1);
  CHECK_FALSE(queue.empty());
  CHECK(next(queue) == 2);
  CHECK(queue.empty());
}

TEST_CASE("An answer takes effect as many steps after its question", "[evaluation][latency]") {
  ActionQueue queue(2);
  answer(queue, {1, 2});
  CHECK_FALSE(queue.empty());  // nobody is asked while an answer is on its way
  CHECK(next(queue) == -1);
  CHECK(next(queue) == -1);
  CHECK(next(queue) == 1);
  CHECK(next(queue) == 2);
  REQUIRE(queue.empty());
  answer(queue, {3});
  CHECK(next(queue) == 2);  // the last action goes on
  CHECK(next(queue) == 2);
  CHECK(next(queue) == 3);
  CHECK(queue.empty());
}

}  // namespace
}  // namespace engram
