#include "protocol/eval/run/evaluate.h"

#include <catch2/catch.hpp>
#include <cstring>
#include <vector>

#include "tests/temporary_folder.h"

namespace engram {
namespace {

constexpr const char* kId = "RememberColor3-VLA-v0";
const JsonTable kHeader = {{"kind", "eval"}};

// Stands still, and counts the episodes that begin.
class Counter final : public ExternalPolicy {
 public:
  explicit Counter(int& begun) : begun_(begun) {}
  void act(const PolicyRequest& request, PolicyReply& reply) override {
    const std::vector<float> still(7, 0);
    const std::int64_t shape[] = {7};
    for (int row = 0; row < request.count; ++row) {
      begun_ += request.first[static_cast<std::size_t>(row)] != 0 ? 1 : 0;
      reply.set(row, still, shape);
    }
  }

 private:
  int& begun_;
};

struct Outcome {
  std::vector<TaskResult> results;
  int begun = 0;
  int wanted = 0;
};

Outcome run(const EpisodeStore& store, int episodes) {
  Outcome outcome;
  Protocol protocol;
  protocol.episodes = episodes;
  protocol.repeat = 2;
  protocol.num_envs = 3;
  protocol.threads = 1;
  protocol.environment.obs_mode = ObsMode::kState;
  protocol.external = [&outcome](const WorkContext&) {
    return std::make_unique<Counter>(outcome.begun);
  };
  Ranks alone;
  evaluate(alone, {&require_entry(kId)}, protocol,
           {.finished = [&](TaskResult result) { outcome.results.push_back(std::move(result)); },
            .tick = [&](const EvaluationStatus& status) { outcome.wanted = status.wanted; }},
           store);
  return outcome;
}

TEST_CASE("Evaluation: episodes of the journal are not played again", "[evaluation]") {
  const test::TemporaryFolder whole;
  const OpenFolder opened(whole.path());
  Journal journal(opened, kHeader);
  const Outcome all = run({.journal = &journal}, 4);
  REQUIRE(all.results.size() == 1);
  CHECK(all.begun == 8);
  CHECK(journal.size() == 8);
  const test::TemporaryFolder part;
  const OpenFolder other(part.path());
  Journal some(other, kHeader);
  for (const int episode : {0, 2, 5, 6}) {
    some.add(kId, episode, journal.records().at(kId).at(episode));
  }
  const Outcome rest = run({.journal = &some}, 4);
  REQUIRE(rest.results.size() == 1);
  CHECK(rest.begun == 4);
  CHECK(some.size() == 8);
  CHECK(rest.results[0].returns == all.results[0].returns);
  CHECK(rest.results[0].lengths == all.results[0].lengths);
  CHECK(rest.results[0].seeds == all.results[0].seeds);
  // Nothing is left to play.
  CHECK(run({.journal = &some}, 4).begun == 0);
}

TEST_CASE("Evaluation: a shard plays its share alone", "[evaluation]") {
  const test::TemporaryFolder folder;
  const OpenFolder opened(folder.path());
  Journal journal(opened, kHeader);
  int begun = 0;
  for (int number = 1; number <= 3; ++number) {
    const Outcome outcome = run({.journal = nullptr, .shard = {number, 3}}, 4);
    CHECK(outcome.results.empty());
    CHECK((outcome.begun == 2 || outcome.begun == 3));
    begun += outcome.begun;
  }
  CHECK(begun == 8);
}

}  // namespace
}  // namespace engram
