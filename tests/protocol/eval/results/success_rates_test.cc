#include "protocol/eval/results/success_rates.h"

#include <catch2/catch.hpp>

#include "tests/protocol/eval/results/evaluation_documents.h"

namespace engram {
namespace {

using test::task_of;

TEST_CASE("Means over tasks have the interval of all their episodes", "[evaluation][results]") {
  const JsonList tasks = {task_of("RememberColor3-VLA-v0", std::vector<bool>(25, true)),
                          task_of("RememberColor5-VLA-v0", std::vector<bool>(25, false)),
                          task_of("SeqOfColors3-Long-VLA-v0", {true, false})};
  const SuccessRate one = success_rate(tasks[0]);
  CHECK(one.rate == 1);
  CHECK(one.interval.low == Approx(wilson_interval(1, 25).low));
  const auto splits = success_rates_by("split", {tasks[0], tasks[1]});
  REQUIRE(splits.size() == 1);
  const SuccessRate& half = splits.begin()->second;
  CHECK(half.rate == 0.5);
  CHECK(half.tasks == 2);
  CHECK(half.episodes == 50);
  CHECK(half.interval.low == Approx(wilson_interval(0.5, 50).low));
  CHECK(mean_success_rate(tasks).episodes == 52);
  CHECK(success_rates_by("split", tasks).size() == 2);
}

TEST_CASE("Repeats that are all alike do not narrow an interval", "[evaluation][results]") {
  EvaluationSettings settings;
  settings.repeat = 3;
  std::vector<bool> round(20);
  for (std::size_t i = 0; i < 5; ++i) round[i] = true;
  std::vector<bool> rounds;
  for (int i = 0; i < 3; ++i) rounds.insert(rounds.end(), round.begin(), round.end());
  const SuccessRate rate = success_rate(task_of("RememberColor3-VLA-v0", rounds, settings));
  CHECK(rate.episodes == 60);
  CHECK(rate.interval.low == Approx(wilson_interval(0.25, 20).low));
  CHECK(rate.interval.high == Approx(wilson_interval(0.25, 20).high));
  CHECK(to_text(Interval{0.123, 0.456}) == "0.12-0.46");
}

}  // namespace
}  // namespace engram
