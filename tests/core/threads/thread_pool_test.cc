#include "core/threads/thread_pool.h"

#include <algorithm>
#include <atomic>
#include <catch2/catch.hpp>
#include <chrono>
#include <cstdint>
#include <limits>
#include <memory>
#include <mutex>
#include <set>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "core/base/error.h"
#include "tests/allocation_counter.h"

namespace engram {
namespace {

// As many threads as a test wants, however few processors there are.
ThreadPool pool_of(int threads, int unit = 1) {
  return ThreadPool(threads, unit, std::make_shared<WorkerThreads>(threads - 1));
}

// Runs a loop and checks that every item was handled once, in ranges as promised.
void check_coverage(ThreadPool& pool, int items, int chunk, int unit = 1) {
  std::vector<int> visits(static_cast<std::size_t>(items));
  std::atomic<int> wrong = 0;  // Catch's macros are not for other threads
  pool.run(items, chunk, [&](int worker, int begin, int end) {
    if (worker < 0 || worker >= pool.threads()) ++wrong;
    if (begin < 0 || end <= begin || end > items || end - begin > chunk) ++wrong;
    if (end < items && (end - begin) % std::min(unit, chunk) != 0) ++wrong;
    for (int i = begin; i < end; ++i) ++visits[static_cast<std::size_t>(i)];
  });
  REQUIRE(wrong == 0);
  for (const int visit : visits) REQUIRE(visit == 1);
}

TEST_CASE("ThreadPool runs every item once", "[thread_pool]") {
  ThreadPool pool = pool_of(GENERATE(1, 2, 3, 8));
  for (const int items : {0, 1, 2, 7, 64, 1000}) {
    for (const int chunk : {1, 2, 3, 64, 1001}) check_coverage(pool, items, chunk);
  }
}

TEST_CASE("ThreadPool cuts ranges in whole units", "[thread_pool]") {
  ThreadPool pool = pool_of(GENERATE(1, 2, 3, 8), 8);
  for (const int items : {1, 8, 12, 64, 1000}) {
    for (const int chunk : {1, 3, 8, 16, 1001}) check_coverage(pool, items, chunk, 8);
  }
}

// Threads that have worked on a loop of N items, each of some microseconds, once its cost
// is known.
std::size_t threads_on(ThreadPool& pool, int items, int microseconds) {
  std::mutex mutex;
  std::set<std::thread::id> ids;
  const auto body = [&](int, int begin, int end) {
    {
      const std::lock_guard lock(mutex);
      ids.insert(std::this_thread::get_id());
    }
    const auto until =
        std::chrono::steady_clock::now() + std::chrono::microseconds(microseconds * (end - begin));
    while (std::chrono::steady_clock::now() < until) continue;
  };
  for (int round = 0; round < 60; ++round) {
    if (round == 50) ids.clear();
    pool.run(items, 1, body);
  }
  return ids.size();
}

TEST_CASE("ThreadPool shares long loops, and keeps short ones to the caller", "[thread_pool]") {
  ThreadPool pool = pool_of(2);
  CHECK(threads_on(pool, 4, 1) == 1);
  CHECK(threads_on(pool, 4, 2000) == 2);
}

TEST_CASE("ThreadPool takes a chunk beyond all items without overflow", "[thread_pool]") {
  ThreadPool pool = pool_of(2);
  constexpr int kMax = std::numeric_limits<int>::max();
  check_coverage(pool, 10, kMax);

  std::atomic<std::int64_t> total = 0;
  pool.run(kMax, kMax - 1, [&](int, int begin, int end) { total += end - begin; });
  CHECK(total == kMax);
}

TEST_CASE("ThreadPool of one runs inline and in order", "[thread_pool]") {
  ThreadPool pool(1);
  CHECK(pool.threads() == 1);
  const auto caller = std::this_thread::get_id();
  std::vector<int> begins;
  pool.run(10, 4, [&](int worker, int begin, int) {
    CHECK(worker == 0);
    CHECK(std::this_thread::get_id() == caller);
    begins.push_back(begin);
  });
  CHECK(begins == std::vector{0, 4, 8});
}

TEST_CASE("ThreadPool calls mutable, const and move-only function objects in place",
          "[thread_pool]") {
  struct Counter {
    std::atomic<int> calls = 0;
    void operator()(int, int, int) { ++calls; }
  };
  ThreadPool pool(2);
  Counter counter;
  pool.run(10, 1, counter);
  CHECK(counter.calls == 10);

  std::atomic<int> calls = 0;
  const auto constant = [&calls](int, int, int) { ++calls; };
  pool.run(5, 1, constant);
  pool.run(5, 1, [&calls, owned = std::make_unique<int>(2)](int, int, int) { calls += *owned; });
  CHECK(calls == 15);
}

TEST_CASE("ThreadPool publishes what was written before and within a loop", "[thread_pool]") {
  ThreadPool pool = pool_of(3);
  std::vector<int> values(300, 1);
  for (int round = 0; round < 200; ++round) {
    pool.run(300, 7, [&](int, int begin, int end) {
      // Another range each round, hence mostly another worker's.
      for (int i = begin; i < end; ++i) ++values[static_cast<std::size_t>((i + 7 * round) % 300)];
    });
  }
  CHECK(values == std::vector<int>(300, 201));
}

TEST_CASE("ThreadPool rethrows the exception of the lowest range", "[thread_pool]") {
  ThreadPool pool = pool_of(GENERATE(1, 2, 4));
  for (int round = 0; round < 50; ++round) {
    std::atomic<int> items = 0;
    const auto body = [&](int, int begin, int end) {
      items += end - begin;
      if (begin >= 30) throw std::runtime_error(std::to_string(begin));
    };
    CHECK_THROWS_WITH(pool.run(100, 10, body), "30");
    CHECK(items == 100);
    check_coverage(pool, 100, 3);
  }
}

TEST_CASE("ThreadPool passes on exceptions of any type", "[thread_pool]") {
  ThreadPool pool(2);
  CHECK_THROWS_AS(pool.run(8, 1, [](int, int, int) { throw 5; }), int);
  check_coverage(pool, 8, 1);
}

TEST_CASE("ThreadPool refuses bad arguments", "[thread_pool]") {
  const auto is_invalid = Catch::Predicate<Error>(
      [](const Error& error) { return error.kind() == Error::kInvalidArgument; });
  for (const int threads : {0, -1, ThreadPool::kMaxThreads + 1}) {
    CHECK_THROWS_MATCHES(ThreadPool(threads), Error, is_invalid);
  }
  CHECK_THROWS_MATCHES(ThreadPool(2, 0), Error, is_invalid);
  ThreadPool pool(2);
  const auto unreachable = [](int, int, int) { throw std::logic_error("was run"); };
  CHECK_THROWS_MATCHES(pool.run(-1, 1, unreachable), Error, is_invalid);
  CHECK_THROWS_MATCHES(pool.run(1, 0, unreachable), Error, is_invalid);
  CHECK_THROWS_MATCHES(pool.run(1, -3, unreachable), Error, is_invalid);
  check_coverage(pool, 8, 1);
}

TEST_CASE("ThreadPool refuses nested loops", "[thread_pool]") {
  ThreadPool pool = pool_of(GENERATE(1, 2));
  const auto nested = [&](int, int, int) { pool.run(4, 1, [](int, int, int) {}); };
  CHECK_THROWS_MATCHES(
      pool.run(4, 1, nested), Error,
      Catch::Predicate<Error>([](const Error& error) { return error.kind() == Error::kBadState; }));
  check_coverage(pool, 8, 1);
}

TEST_CASE("ThreadPool does not allocate while running", "[thread_pool]") {
  ThreadPool pool = pool_of(GENERATE(1, 3));
  std::vector<int> values(1000);
  const auto body = [&](int, int begin, int end) {
    for (int i = begin; i < end; ++i) ++values[static_cast<std::size_t>(i)];
  };
  pool.run(1000, 10, body);
  const std::int64_t before = test::allocation_count();
  for (int round = 0; round < 100; ++round) pool.run(1000, 10, body);
  CHECK(test::allocation_count() == before);
}

TEST_CASE("ThreadPools come and go", "[thread_pool]") {
  for (int round = 0; round < 200; ++round) {
    ThreadPool pool(1 + round % 5);
    if (round % 2 == 0) check_coverage(pool, 20, 3);
  }
}

}  // namespace
}  // namespace engram
