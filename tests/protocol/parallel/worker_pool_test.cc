#include "protocol/parallel/worker_pool.h"

#include <catch2/catch.hpp>
#include <chrono>
#include <map>
#include <stdexcept>
#include <thread>

namespace engram {
namespace {

using std::chrono::milliseconds;

void double_count(const WorkItem& item, const WorkContext& context) {
  context.count_env_steps(1);
  ByteWriter out;
  out.put(2 * item.count);
  context.emit(out.take());
}

TEST_CASE("Worker pool: every item comes back once, by its number", "[work]") {
  const WorkFunction work = double_count;
  WorkerPool pool(3, work);
  constexpr int kItems = 20;
  for (int i = 0; i < kItems; ++i) pool.start(static_cast<std::uint64_t>(100 + i), {0, 0, i});
  std::map<std::uint64_t, int> results;
  int finished = 0;
  while (finished < kItems) {
    for (const WorkReport& report : pool.wait(milliseconds(1000))) {
      REQUIRE_FALSE(report.error);
      if (report.finished) {
        ++finished;
        CHECK(results.contains(report.number));
        continue;
      }
      CHECK(results.emplace(report.number, ByteReader(report.result).get<int>()).second);
    }
  }
  for (const auto& [number, value] : results) CHECK(value == 2 * static_cast<int>(number - 100));
  CHECK(pool.env_steps() == kItems);
  CHECK(pool.wait(milliseconds(0)).empty());
}

TEST_CASE("Worker pool: a stopped item returns", "[work]") {
  const WorkFunction work = [](const WorkItem&, const WorkContext& context) {
    while (!context.stopped()) std::this_thread::sleep_for(milliseconds(1));
  };
  WorkerPool pool(1, work);
  pool.start(1, {});
  CHECK(pool.wait(milliseconds(10)).empty());
  pool.stop(1);
  const auto done = pool.wait(milliseconds(10'000));
  REQUIRE(done.size() == 1);
  CHECK(done[0].number == 1);
}

TEST_CASE("Worker pool: an exception is the item's result", "[work]") {
  const WorkFunction work = [](const WorkItem&, const WorkContext&) {
    throw std::runtime_error("broken");
  };
  WorkerPool pool(1, work);
  pool.start(1, {});
  const auto done = pool.wait(milliseconds(10'000));
  REQUIRE(done.size() == 1);
  CHECK_THROWS_WITH(std::rethrow_exception(done[0].error), "broken");
}

TEST_CASE("Worker pool: its end stops what is in progress", "[work]") {
  const WorkFunction work = [](const WorkItem&, const WorkContext& context) {
    while (!context.stopped()) std::this_thread::sleep_for(milliseconds(1));
  };
  WorkerPool pool(2, work);
  for (std::uint64_t i = 0; i < 5; ++i) pool.start(i, {});
}

}  // namespace
}  // namespace engram
