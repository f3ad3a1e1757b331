// The worked values of the shell games' dense rewards.
#include <catch2/catch.hpp>

#include "tasks/shell_game/pick.h"
#include "tasks/shell_game/push.h"
#include "tasks/shell_game/touch_rule.h"

namespace engram::tasks {
namespace {

TEST_CASE("Rewards of touching a mug equal the worked values", "[shell]") {
  struct Row {
    TouchRule::Reward in;
    double reward;
  };
  Row rows[] = {
      {{0.2, 0.6, 0, false, false, true, false}, 0.238406},
      {{0.07, 0.3, 0.01, false, true, true, false}, 0.748509},
      {{0.07, 0.1, 0.06, true, true, true, false}, 2.147802},
      {{0.07, 0.1, 0.02, true, true, true, true}, 3},
      {{0.07, 0.1, 0, true, true, false, false}, 0},
  };
  for (Row& row : rows) {
    CHECK(row.in.compute() == Approx(row.reward).margin(1e-6));
  }
  const TouchRule::Reward& terms = rows[2].in;
  CHECK(terms.reaching == Approx(0.663624).margin(1e-6));
  CHECK(terms.stillness == Approx(0.537883).margin(1e-6));
  CHECK(terms.shift == Approx(0.053705).margin(1e-6));
}

TEST_CASE("Rewards of pushing a mug equal the worked values", "[shell]") {
  struct Row {
    PushReward in;
    double reward;
  };
  Row rows[] = {
      {{0.15, 0.10004, 0.4, false, false, true, false}, 0.094852},
      {{0.07, 0.10004, 0.4, false, false, true, false}, 1.471083},
      {{0.07, 0.05, 0.6, false, true, true, false}, 1.906784},
      {{0.07, 0.05, 0.2, true, true, true, true}, 4},
      {{0.07, 0.05, 0.2, true, true, false, false}, 0},
  };
  for (Row& row : rows) {
    CHECK(row.in.compute() == Approx(row.reward).margin(1e-6));
  }
  CHECK(rows[1].in.place == Approx(0.537726).margin(1e-6));
}

TEST_CASE("Rewards of picking up a mug equal the worked values", "[shell]") {
  struct Row {
    PickReward in;
    double reward;
  };
  Row rows[] = {
      {{0.1, 0.09205, 0.4, 0.08, false, false, false, true, false}, 2.215218},
      {{0.03, 0.09205, 0.1, 0.05, false, true, false, true, false}, 4.126062},
      {{0.0519, 0.09205, 0.1, 0.02, true, true, false, true, false}, 19.035578},
      {{0.0519, 0.07, 0.4, 0.02, true, false, true, true, false}, 22.032812},
      {{0.3, 0.07, 0.1, 0.08, false, true, true, true, true}, 75},
      {{0.3, 0.07, 0.1, 0.08, true, true, true, false, false}, 0},
  };
  for (Row& row : rows) {
    CHECK(row.in.compute() == Approx(row.reward).margin(1e-6));
  }
  CHECK(rows[2].in.open == Approx(0.25));
}

}  // namespace
}  // namespace engram::tasks
