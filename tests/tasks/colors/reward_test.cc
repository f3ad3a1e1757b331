// Bookkeeping of touches and the dense reward of the colour families.
#include "tasks/colors/reward.h"

#include <array>
#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "tasks/common/touch_latch.h"

namespace engram::tasks {
namespace {

constexpr std::array<std::int32_t, 3> kCue = {4, 1, 7};

TouchTally after(ColorRule rule, const std::vector<int>& touches) {
  std::array<std::uint8_t, 9> touched{};
  std::array<std::int32_t, 3> order = {-1, -1, -1};
  for (const int color : touches) {
    if (touched[static_cast<std::size_t>(color)] != 0) continue;
    touched[static_cast<std::size_t>(color)] = 1;
    append_touch(order.data(), 3, color);
  }
  return tally_touches(rule, kCue, touched, order.data());
}

TEST_CASE("Touches are booked as in the worked examples", "[touch]") {
  struct Row {
    std::vector<int> touches;
    bool all;
    bool chain_order;
    int chain_correct, chain_wrong, chain_next;
    int correct, wrong, seq_next, bunch_next;
  };
  const Row rows[] = {
      {{4}, false, false, 1, 0, 1, 1, 0, 1, 1},
      {{7}, false, false, 0, 1, 4, 1, 0, 4, 1},
      {{4, 7}, false, false, 1, 1, 1, 2, 0, 1, 1},
      {{4, 7, 1}, true, false, 1, 2, 1, 3, 0, -1, -1},
      {{1, 4, 7}, true, false, 1, 2, 4, 3, 0, -1, -1},
      {{4, 1, 7}, true, true, 3, 0, -1, 3, 0, -1, -1},
      {{4, 1, 3}, false, false, 2, 1, 7, 2, 1, 7, 7},
      {{4, 1, 7, 3}, false, false, 2, 1, 4, 3, 1, -1, -1},
      {{4, 4, 1, 4}, false, false, 2, 0, 7, 2, 0, 7, 7},
  };
  for (const Row& row : rows) {
    std::string name;
    for (const int color : row.touches) name += std::to_string(color) + " ";
    INFO("touches " << name);
    const TouchTally chain = after(ColorRule::kChain, row.touches);
    const TouchTally seq = after(ColorRule::kSeq, row.touches);
    const TouchTally bunch = after(ColorRule::kBunch, row.touches);
    for (const TouchTally& tally : {chain, seq, bunch}) {
      CHECK(tally.all_touched == row.all);
      CHECK(tally.no_extra == (row.wrong == 0));
    }
    CHECK(chain.order_ok == row.chain_order);
    CHECK(chain.correct == row.chain_correct);
    CHECK(chain.wrong == row.chain_wrong);
    CHECK(chain.next == row.chain_next);
    CHECK(seq.order_ok);
    CHECK(seq.correct == row.correct);
    CHECK(seq.wrong == row.wrong);
    CHECK(seq.next == row.seq_next);
    CHECK(bunch.order_ok);
    CHECK(bunch.correct == row.correct);
    CHECK(bunch.wrong == row.wrong);
    CHECK(bunch.next == row.bunch_next);
    CHECK(seq.complete() == row.all);
    CHECK(chain.complete() == (row.all && row.chain_order));
  }
}

TEST_CASE("Upstream's Seq asks for the order too", "[touch]") {
  struct Row {
    std::vector<int> touches;
    bool order_ok;
    int correct, next;
  };
  const Row rows[] = {{{}, true, 0, 4},         {{4}, true, 1, 1},      {{7}, false, 1, -1},
                      {{4, 1}, true, 2, 7},     {{4, 7}, false, 2, -1}, {{4, 1, 7}, true, 3, -1},
                      {{1, 4, 7}, false, 3, -1}};
  for (const Row& row : rows) {
    const TouchTally tally = after(ColorRule::kSeqStrict, row.touches);
    CHECK(tally.order_ok == row.order_ok);
    CHECK(tally.correct == row.correct);
    CHECK(tally.next == row.next);
    CHECK(tally.complete() == (row.order_ok && row.correct == 3));
  }
}

TEST_CASE("The colour reward has the worked values", "[reward]") {
  const auto reward = [](int length, double goal, double speed, int correct, int wrong,
                         double displacement) {
    ColorReward in;
    in.touches.length = length;
    in.touches.goal_distance = goal;
    in.touches.arm_speed = speed;
    in.touches.tally.correct = correct;
    in.touches.tally.wrong = wrong;
    in.touches.acting = true;
    in.mean_displacement = displacement;
    return in;
  };
  const auto value = [](ColorReward in) { return in.compute(); };
  CHECK(value(reward(3, 0.1, 0.1, 1, 1, 0.002)) == Approx(20.467347).margin(6e-7));
  CHECK(value(reward(3, 0.1, 0.1, 1, 2, 0.002)) == Approx(10.467347).margin(6e-7));
  CHECK(value(reward(3, 0.25, 0.4, 0, 0, 0)) == Approx(0.0313719).margin(6e-8));
  CHECK(value(reward(5, 0, 0.02, 5, 0, 0.004)) == Approx(91.370166).margin(6e-7));
  CHECK(value(reward(3, 0.1, 0.1, 1, 1, 0.002)) / kColorSuccessReward ==
        Approx(0.0511684).margin(6e-8));
  CHECK(value(reward(5, 0, 0.02, 5, 0, 0.004)) / kColorSuccessReward ==
        Approx(0.2284254).margin(6e-8));
  ColorReward early = reward(3, 0, 0, 3, 0, 0);
  early.touches.acting = false;
  CHECK(value(early) == 0);
  ColorReward done = reward(3, 0.3, 1, 3, 0, 0.02);
  done.touches.success = true;
  CHECK(value(done) == 400);
}

TEST_CASE("The RL tasks' colour reward has the worked values", "[reward][rl]") {
  const auto value = [](int length, double goal, double speed, int correct, int wrong) {
    ColorTouchReward in{.goal_distance = goal, .arm_speed = speed, .length = length};
    in.tally.correct = correct;
    in.tally.wrong = wrong;
    in.acting = true;
    return in.compute();
  };
  CHECK(value(3, 0.1, 0.1, 1, 1) == Approx(20.507347).margin(6e-7));
  CHECK(value(3, 0.25, 0.4, 0, 0) == Approx(0.031372).margin(6e-7));
  CHECK(value(5, 0, 0.02, 5, 0) == Approx(91.450166).margin(6e-7));
  ColorTouchReward in;
  CHECK(in.compute() == 0);  // too early
  in.success = true;
  CHECK(in.compute() == 100);
}

TEST_CASE("A touch is a mistake where it can no longer be corrected", "[touch][answer]") {
  using enum ColorRule;
  const auto mistaken = [](ColorRule rule, const std::vector<int>& touches) {
    return after(rule, touches).mistaken;
  };
  for (const ColorRule rule : {kBunch, kSeq, kSeqStrict, kChain}) {
    CHECK_FALSE(mistaken(rule, {}));
    CHECK_FALSE(mistaken(rule, {4, 1}));
    CHECK_FALSE(mistaken(rule, {4, 1, 7}));
    CHECK(mistaken(rule, {5}));
    CHECK(mistaken(rule, {4, 5}));
    const bool ordered = rule == kSeqStrict || rule == kChain;
    CHECK(mistaken(rule, {1}) == ordered);
    CHECK(mistaken(rule, {4, 7}) == ordered);
  }
}

TEST_CASE("The number of an answer has a digit per touch", "[touch][answer]") {
  const std::array<std::int32_t, 4> order = {4, 0, 8, -1};
  CHECK(answer_number(order.data(), 4) == 519);
  CHECK(answer_number(order.data(), 2) == 51);
  CHECK(answer_number(order.data() + 3, 1) == 0);
}

}  // namespace
}  // namespace engram::tasks
