// `engram soak`, and that what it watches for would be noticed.
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

#include "protocol/batch/make.h"
#include "tests/apps/command.h"
#include "tests/sanitizers.h"

namespace engram::tests {
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

// --- what must be noticed ---

TEST_CASE("soak: a leak of memory is noticed", "[soak]") {
  if (test::kSanitized) return;
  std::vector<std::unique_ptr<std::vector<char>>> leaked;
  const bench::SoakReport report = short_soak(
      0, 20, [&leaked] { leaked.push_back(std::make_unique<std::vector<char>>(100'000, 'x')); });
  CHECK_FALSE(bound(report, "cycles.heap_growth").kept());
  CHECK_FALSE(report.passed());
}

TEST_CASE("soak: a descriptor that stays open is noticed", "[soak]") {
  std::vector<int> opened;
  const bench::SoakReport report =
      short_soak(0, 10, [&opened] { opened.push_back(open("/dev/null", O_RDONLY)); });
  for (const int descriptor : opened) close(descriptor);
  CHECK_FALSE(bound(report, "cycles.more_descriptors").kept());
  CHECK_FALSE(report.passed());
}

TEST_CASE("soak: a thread that stays is noticed", "[soak]") {
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

// --- what is reported ---

TEST_CASE("soak: one that is stopped reports what it did", "[soak]") {
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

TEST_CASE("soak: an interrupted command tells what was done, and fails", "[apps][soak]") {
  const CommandResult result =
      engram_command(std::string("soak ") + kId + " --env-steps 100000000 --max-drift 1000 --json",
                     "& sleep 2; kill -TERM $!; wait $!");
  INFO(result.err);
  CHECK(result.code == 1);
  CHECK_THAT(result.err, Catch::Contains("interrupted; reported is what was done until then"));
  const Json report = Json::parse(result.out);
  CHECK(report["stopped"] == true);
  CHECK(report["env_steps"].get<int>() > 0);
}

TEST_CASE("soak: visits go on where the last one ended, and repeat their fixed work", "[soak]") {
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

TEST_CASE("soak: the command's fields, and nothing lost in a few steps and cycles",
          "[apps][soak]") {
  if (test::kSanitized) return;  // the bounds are of the ordinary heap
  const Json report = engram_command(std::string("soak ") + kId +
                                     " TakeItBack-VLA-v0 --env-steps 600 --cycles 40 "
                                     "--max-drift 1000 --json")
                          .json();
  CHECK(keys_of(report) == std::vector<std::string>{"env_steps", "cycles", "threads", "stopped",
                                                    "step_seconds", "cycle_seconds", "passed",
                                                    "bounds", "unstable", "tasks", "step_samples",
                                                    "cycle_samples"});
  CHECK(report["passed"] == true);
  CHECK(report["env_steps"].get<int>() >= 600);
  CHECK(report["cycles"] == 40);
  CHECK(report["unstable"].empty());
  CHECK(report["tasks"].size() == 2);
  CHECK(report["tasks"][1]["id"] == "TakeItBack-VLA-v0");
  CHECK(report["tasks"][0]["visits"].size() == 3);
  CHECK(report["step_samples"].size() == 6);
  CHECK(report["cycle_samples"].size() == 40);
  for (const Json& sample : report["cycle_samples"]) {
    CHECK(sample["resident_bytes"].get<double>() > sample["allocated_bytes"].get<double>());
    CHECK(sample["threads"] == 1);
  }
  REQUIRE(report["bounds"].size() == 12);
  for (const Json& bound : report["bounds"]) {
    INFO(bound["name"]);
    CHECK(bound["kept"] == true);
  }
}

TEST_CASE("soak: refusals", "[apps][soak]") {
  require_refusal("soak RemembrColor3-VLA-v0", 2, kId);
  require_refusal("soak --env-steps -1", 2, "--env-steps");
  require_refusal("soak --max-drift 0", 2, "--max-drift");
  require_refusal("soak --cycles many", 2, "--cycles");
}

}  // namespace
}  // namespace engram::tests
