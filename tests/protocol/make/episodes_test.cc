#include "protocol/make/episodes.h"

#include <atomic>
#include <catch2/catch.hpp>
#include <set>

#include "core/batch/scripted_policy.h"

namespace engram {
namespace {

constexpr const char* kId = "RememberColor3-VLA-v0";

// Notes the calls of play_episodes.
struct Log {
  Batch& batch;
  std::vector<int> started;
  std::vector<int> finished;
  std::set<std::uint64_t> seeds;
  int before = 0;
  int after = 0;

  void start(int env, int i) {
    started.push_back(i);
    seeds.insert(batch.state().seed[env]);
  }
  void before_step(int, std::span<float>) { ++before; }
  void after_step(int) { ++after; }
  void finish(int, int i) { finished.push_back(i); }
};

class Play {
 public:
  bool run(Batch& batch, int count, Log& log) {
    const ScriptedPolicy policy(batch, Policy::kRandom);
    return play_episodes(
        batch, 100, count, WorkContext(0, stopped, steps),
        [&](std::span<float> actions) { policy.act(actions); }, log);
  }

  std::atomic<bool> stopped = false;
  std::atomic<std::uint64_t> steps = 0;
};

TEST_CASE("Consecutive seeds are played once each, with fewer environments than episodes",
          "[episodes]") {
  MakeOptions options;
  options.max_episode_steps = 4;
  EpisodeBatch reusable;
  Batch& batch = reusable.of(kId, 5, 2, options);
  CHECK(batch.num_envs() == 2);
  CHECK(batch.options().auto_reset == AutoReset::kOff);
  Log log{batch, {}, {}, {}};
  Play play;
  CHECK(play.run(batch, 5, log));
  CHECK(log.started == std::vector<int>{0, 1, 2, 3, 4});
  CHECK(log.finished == std::vector<int>{0, 1, 2, 3, 4});
  CHECK(log.seeds == std::set<std::uint64_t>{100, 101, 102, 103, 104});
  CHECK(log.before == 5 * 4);
  CHECK(log.after == log.before);
  CHECK(play.steps == 5 * 4);
}

TEST_CASE("A stop ends the play", "[episodes]") {
  EpisodeBatch reusable;
  Batch& batch = reusable.of(kId, 2, 2, MakeOptions());
  Log log{batch, {}, {}, {}};
  Play play;
  play.stopped = true;
  CHECK_FALSE(play.run(batch, 2, log));
  CHECK(log.finished.empty());
}

TEST_CASE("A batch is kept while the task stays and it is large enough", "[episodes]") {
  EpisodeBatch reusable;
  const Batch* first = &reusable.of(kId, 3, 2, MakeOptions());
  CHECK(&reusable.of(kId, 1, 2, MakeOptions()) == first);
  CHECK(reusable.of(kId, 3, 3, MakeOptions()).num_envs() == 3);
  CHECK(reusable.of("RememberColor5-VLA-v0", 3, 3, MakeOptions()).info().id ==
        "RememberColor5-VLA-v0");
}

}  // namespace
}  // namespace engram
