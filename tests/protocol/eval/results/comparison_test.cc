#include "protocol/eval/results/comparison.h"

#include <catch2/catch.hpp>

#include "protocol/eval/results/statistics.h"
#include "tests/protocol/eval/results/evaluation_documents.h"

namespace engram {
namespace {

using Catch::Contains;
using test::task_of;
using test::with_value;

constexpr const char* kId = "RememberColor3-VLA-v0";
constexpr const char* kOther = "SeqOfColors3-Long-VLA-v0";

ResultSet results(const char* name, JsonList tasks) { return {name, std::move(tasks)}; }

// A succeeds in 12 episodes in which B fails, B in 3; 20 and 5 are alike.
const std::vector<bool> kA = [] {
  std::vector<bool> a(40);
  std::fill_n(a.begin(), 32, true);
  return a;
}();
const std::vector<bool> kB = [] {
  std::vector<bool> b(40);
  std::fill_n(b.begin(), 20, true);
  std::fill_n(b.begin() + 32, 3, true);
  return b;
}();

TEST_CASE("Comparisons pair episodes by id and seed", "[evaluation][compare]") {
  const ResultSet a = results("a", {task_of(kId, kA), task_of(kOther, kA)});
  const ResultSet b = results("b", {task_of(kOther, kB), task_of(kId, kB)});  // another order
  const Json comparison = compare_results(a, b, {});
  const Json& task = list(part(comparison, "tasks"))[0];
  CHECK(text(part(task, "env_id")) == kId);
  CHECK(number(part(task, "pairs")) == 40);
  CHECK(number(part(task, "both")) == 20);
  CHECK(number(part(task, "only_a")) == 12);
  CHECK(number(part(task, "only_b")) == 3);
  CHECK(number(part(task, "neither")) == 5);
  CHECK(number(part(task, "difference")) == Approx(0.225));
  CHECK(number(part(task, "p_value")) == Approx(0.03515625));
  CHECK(number(part(task, "p_value_holm")) == Approx(0.0703125));
  const Interval interval = paired_interval({20, 12, 3, 5});
  CHECK(number(list(part(task, "difference_interval"))[0]) == Approx(interval.low));
  CHECK(number(part(task, "smallest_difference")) == Approx(6.0 / 40));
  const Json& total = part(comparison, "total");
  CHECK(number(part(total, "pairs")) == 80);
  CHECK(number(part(total, "n_tasks")) == 2);
  CHECK(number(part(total, "p_value")) == Approx(mcnemar_p_value(24, 6)));
  CHECK(table(part(comparison, "splits")).size() == 2);
  CHECK(number(part(part(part(comparison, "splits"), "Short"), "pairs")) == 40);
}

TEST_CASE("Comparisons count episodes with the same digests", "[evaluation][compare]") {
  const ResultSet a = results("a", {task_of(kId, {true, true, false})});
  const ResultSet b = results("b", {task_of(kId, {true, false, false})});
  const Json same = part(part(compare_results(a, b, {}), "total"), "same_digests");
  CHECK(number(part(same, "observations")) == 3);
  CHECK(number(part(same, "first_observations")) == 3);
  CHECK(number(part(same, "answers")) == 2);
  const ResultSet old = results("b", {with_value(b.tasks[0], "digests", nullptr)});
  CHECK(is_null(part(part(compare_results(a, old, {}), "total"), "same_digests")));
}

TEST_CASE("Comparisons of repeats count seeds", "[evaluation][compare]") {
  EvaluationSettings settings;
  settings.repeat = 2;
  std::vector<bool> twice = kA;
  twice.insert(twice.end(), kA.begin(), kA.end());
  std::vector<bool> other = kB;
  other.insert(other.end(), kB.begin(), kB.end());
  const Json total = part(compare_results(results("a", {task_of(kId, twice, settings)}),
                                          results("b", {task_of(kId, other, settings)}), {}),
                          "total");
  CHECK(number(part(total, "pairs")) == 80);
  CHECK(text(part(total, "test")) == "exact sign flips of seeds");
  // Rounds that are all alike prove no more than one.
  CHECK(number(part(total, "p_value")) == Approx(0.03515625));
  CHECK(number(part(total, "difference")) == Approx(0.225));
  const JsonList& interval = list(part(total, "difference_interval"));
  CHECK(number(interval[0]) == Approx(0.225 - 0.184).margin(0.01));
}

TEST_CASE("Results that do not pair are refused", "[evaluation][compare]") {
  const ResultSet a = results("a", {task_of(kId, {true, false}), task_of(kOther, {true, false})});
  const ResultSet fewer = results("b", {task_of(kId, {true, false})});
  const auto refuse = [](const ResultSet& one, const ResultSet& other,
                         const std::set<AllowedDifference>& allowed, const auto& words) {
    CHECK_THROWS_WITH(compare_results(one, other, allowed), words);
  };
  refuse(a, fewer, {}, Contains("'a' has SeqOfColors3-Long-VLA-v0, and 'b' has not; allow ids"));
  refuse(fewer, a, {}, Contains("'a' has SeqOfColors3-Long-VLA-v0, and 'b' has not"));
  CHECK(number(part(part(compare_results(a, fewer, {AllowedDifference::kIds}), "total"),
                    "n_tasks")) == 1);
  const ResultSet foreign = results("c", {task_of(kOther, {true, false})});
  refuse(fewer, foreign, {AllowedDifference::kIds}, Contains("have no task in common"));

  const ResultSet more = results("c", {task_of(kId, {true, false, true})});
  refuse(fewer, more, {},
         Contains("the seeds of RememberColor3-VLA-v0 do not pair: 2 episodes in 'b', 3 in 'c', 2 "
                  "of them in both; allow seeds"));
  CHECK(number(part(part(compare_results(fewer, more, {AllowedDifference::kSeeds}), "total"),
                    "pairs")) == 2);
  EvaluationSettings elsewhere;
  elsewhere.start_seed = 7;
  refuse(fewer, results("d", {task_of(kId, {true, false}, elsewhere)}), {AllowedDifference::kSeeds},
         Contains("0 of them in both"));
  refuse(fewer, results("e", {with_value(fewer.tasks[0], "episode_seeds", nullptr)}), {},
         Contains("'e' is sealed"));
}

TEST_CASE("Results of other environments are refused unless that is allowed",
          "[evaluation][compare]") {
  const ResultSet a = results("a", {task_of(kId, {true, false})});
  const std::tuple<const char*, Json, AllowedDifference> edits[] = {
      {"version", "0.4.0", AllowedDifference::kVersion},
      {"rules", "original", AllowedDifference::kRules}};
  for (const auto& [key, value, allowed] : edits) {
    const ResultSet b = results("b", {with_value(a.tasks[0], key, value)});
    CHECK_THROWS_WITH(compare_results(a, b, {}), Contains(std::string(kId) + ": " + key) &&
                                                     Contains(text(value)) &&
                                                     Contains(std::string("allow ") + key));
    CHECK_NOTHROW(compare_results(a, b, {allowed}));
  }
  EvaluationSettings changed;
  changed.task_options = {{"strict", 1}};
  const ResultSet c = results("c", {task_of(kId, {true, false}, changed)});
  CHECK_THROWS_WITH(compare_results(a, c, {}), Contains("strict") && Contains("allow constants"));
  CHECK_NOTHROW(compare_results(a, c, {AllowedDifference::kConstants}));

  EvaluationSettings perturbed;
  perturbed.perturbations = {{PerturbationAxis::kBlur, 0.5}};
  const ResultSet d = results("d", {task_of(kId, {true, false}, perturbed)});
  CHECK_THROWS_WITH(compare_results(a, d, {}), Contains("blur") && Contains("allow constants"));

  EvaluationSettings other_physics;
  other_physics.physics = Physics::kMujoco;
  const ResultSet e = results("e", {task_of(kId, {true, false}, other_physics)});
  CHECK_THROWS_WITH(compare_results(a, e, {}),
                    Contains("physics \"engram\" in 'a', \"mujoco ") && Contains("allow physics"));
  CHECK_NOTHROW(compare_results(a, e, {AllowedDifference::kPhysics}));
}

}  // namespace
}  // namespace engram
