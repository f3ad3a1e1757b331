#include "bench/soak.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "tests/sanitizers.h"

namespace engram {
namespace {

constexpr const char* kId = "RememberColor3-VLA-v0";

// A short soak that calls `misbehave` now and then.
bench::SoakReport short_soak(int env_steps, int cycles, const std::function<void()>& misbehave) {
  bench::SoakOptions options;
  options.ids = {kId};
  options.env_steps = env_steps;
  options.cycles = cycles;
  options.threads = 2;
  options.progress = [&misbehave](double /*fraction*/) { misbehave(); };
  return bench::soak(options);
}

const bench::SoakBound& bound(const bench::SoakReport& report, const std::string& name) {
  const auto found = std::find_if(report.bounds.begin(), report.bounds.end(),
                                  [&name](const auto& entry) { return entry.name == name; });
  REQUIRE(found != report.bounds.end());
  return *found;
}

// --- faults that must be found ---

TEST_CASE("soak: a leak of memory is found", "[soak]") {
  if (test::kSanitized) return;
  std::vector<std::unique_ptr<std::vector<char>>> leaked;
  const bench::SoakReport report = short_soak(
      0, 20, [&leaked] { leaked.push_back(std::make_unique<std::vector<char>>(100'000, 'x')); });
  CHECK_FALSE(bound(report, "cycles.heap_growth").kept());
  CHECK_FALSE(report.passed());
}

TEST_CASE("soak: a descriptor that stays open is found", "[soak]") {
  std::vector<int> opened;
  const bench::SoakReport report =
      short_soak(0, 10, [&opened] { opened.push_back(open("/dev/null", O_RDONLY)); });
  for (const int descriptor : opened) close(descriptor);
  CHECK_FALSE(bound(report, "cycles.more_descriptors").kept());
  CHECK_FALSE(report.passed());
}

TEST_CASE("soak: a thread that stays is found", "[soak]") {
  std::mutex mutex;
  std::condition_variable over;
  bool done = false;
  std::vector<std::thread> threads;
  const bench::SoakReport report = short_soak(0, 10, [&] {
    threads.emplace_back([&] {
      std::unique_lock lock(mutex);
      over.wait(lock, [&done] { return done; });
    });
  });
  {
    const std::lock_guard lock(mutex);
    done = true;
  }
  over.notify_all();
  for (std::thread& thread : threads) thread.join();
  CHECK_FALSE(bound(report, "cycles.more_threads").kept());
  CHECK_FALSE(report.passed());
}

// --- the report ---

TEST_CASE("soak: a stopped run reports its part of the work", "[soak]") {
  bench::SoakOptions options;
  options.ids = {kId, "TakeItBack-VLA-v0"};
  options.env_steps = 2 * 3 * 10 * 32;
  options.cycles = 5;
  options.stop = [] { return true; };
  const bench::SoakReport report = bench::soak(options);
  CHECK(report.stopped);
  CHECK(report.env_steps == 10 * 32);  // one visit
  CHECK(report.step_samples.size() == 1);
  REQUIRE(report.tasks.size() == 2);
  CHECK(report.tasks[0].visits.size() == 1);
  CHECK(report.tasks[1].visits.empty());
  CHECK(bound(report, "steps.drift").value == 1);
  CHECK(report.cycles == 0);
}

TEST_CASE("soak: visits continue from the last one, and repeat their fixed work", "[soak]") {
  // 3 visits of 60 steps: 7 episodes of 25 steps in each of 32 environments.
  const bench::SoakReport report = short_soak(3 * 60 * 32, 0, [] {});
  CHECK(report.env_steps == 3 * 60 * 32);
  REQUIRE(report.tasks.size() == 1);
  const std::vector<bench::SoakVisit>& visits = report.tasks.front().visits;
  REQUIRE(visits.size() == 3);
  int episodes[2] = {0, 0};
  int successes[2] = {0, 0};
  for (const bench::SoakVisit& visit : visits) {
    CHECK(visit.env_steps_per_second > 0);
    CHECK(visit.digest == visits.front().digest);
    for (const std::size_t i : {0U, 1U}) {
      episodes[i] += visit.episodes[i];
      successes[i] += visit.successes[i];
    }
  }
  CHECK(visits.front().drift == 1);
  // Environments take turns: one more or one less episode of either policy each, in seven.
  CHECK(episodes[0] == 7 * 16);
  CHECK(episodes[1] == 7 * 16);
  CHECK(successes[0] < 7 * 16 / 4);
  CHECK(successes[1] > 7 * 16 * 9 / 10);
  CHECK(report.unstable.empty());
  CHECK(bound(report, "steps.changed_results").kept());
  CHECK(bound(report, "steps.unstable").kept());
  if (!test::kSanitized) CHECK(bound(report, "steps.heap_growth_in_a_visit").value == 0);
}

}  // namespace
}  // namespace engram
