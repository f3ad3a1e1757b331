#include "core/base/thread_pool.h"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <catch2/catch.hpp>
#include <chrono>
#include <cstdint>
#include <ctime>
#include <fstream>
#include <limits>
#include <memory>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "tests/allocation_counter.h"
#include "tests/sanitizers.h"

namespace engram {
namespace {

using test::kSanitized;

// Runs a loop and checks that every item was handled once, in ranges as promised.
void check_coverage(ThreadPool& pool, int items, int chunk) {
  std::vector<int> visits(static_cast<std::size_t>(items));
  std::atomic<int> wrong = 0;  // Catch's macros are not for other threads
  pool.run(items, chunk, [&](int worker, int begin, int end) {
    if (worker < 0 || worker >= pool.threads()) ++wrong;
    if (begin < 0 || end <= begin || end > items || end - begin > chunk) ++wrong;
    const bool shared = pool.threads() > 1 && items > chunk;
    const int left = items - begin;
    const int longest = shared ? std::max(1, left / (2 * pool.threads())) : left;
    if (end - begin != std::min(chunk, longest)) ++wrong;
    for (int i = begin; i < end; ++i) ++visits[static_cast<std::size_t>(i)];
  });
  REQUIRE(wrong == 0);
  for (const int visit : visits) REQUIRE(visit == 1);
}

TEST_CASE("ThreadPool runs every item once", "[thread_pool]") {
  ThreadPool pool(GENERATE(1, 2, 3, 8));
  for (const int items : {0, 1, 2, 7, 64, 1000}) {
    for (const int chunk : {1, 2, 3, 64, 1001}) check_coverage(pool, items, chunk);
  }
}

TEST_CASE("ThreadPool takes a chunk beyond all items without overflow", "[thread_pool]") {
  ThreadPool pool(2);
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

TEST_CASE("ThreadPool gives every worker a thread of its own, the caller being worker 0",
          "[thread_pool]") {
  constexpr int kThreads = 4;
  ThreadPool pool(kThreads);
  std::vector<std::thread::id> ids(kThreads);
  std::atomic<int> arrived = 0;
  // Nobody leaves before all have come, so each of them gets one range.
  pool.run(kThreads, 1, [&](int worker, int, int) {
    ids[static_cast<std::size_t>(worker)] = std::this_thread::get_id();
    ++arrived;
    while (arrived < kThreads) std::this_thread::yield();
  });
  CHECK(ids[0] == std::this_thread::get_id());
  CHECK(std::set<std::thread::id>(ids.begin(), ids.end()).size() == kThreads);
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
  ThreadPool pool(3);
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
  ThreadPool pool(GENERATE(1, 2, 4));
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
  ThreadPool pool(2);
  const auto unreachable = [](int, int, int) { throw std::logic_error("was run"); };
  CHECK_THROWS_MATCHES(pool.run(-1, 1, unreachable), Error, is_invalid);
  CHECK_THROWS_MATCHES(pool.run(1, 0, unreachable), Error, is_invalid);
  CHECK_THROWS_MATCHES(pool.run(1, -3, unreachable), Error, is_invalid);
  check_coverage(pool, 8, 1);
}

TEST_CASE("ThreadPool refuses nested loops", "[thread_pool]") {
  ThreadPool pool(GENERATE(1, 2));
  const auto nested = [&](int, int, int) { pool.run(4, 1, [](int, int, int) {}); };
  CHECK_THROWS_MATCHES(
      pool.run(4, 1, nested), Error,
      Catch::Predicate<Error>([](const Error& error) { return error.kind() == Error::kBadState; }));
  check_coverage(pool, 8, 1);
}

TEST_CASE("ThreadPool does not allocate while running", "[thread_pool]") {
  ThreadPool pool(GENERATE(1, 3));
  std::vector<int> values(1000);
  const auto body = [&](int, int begin, int end) {
    for (int i = begin; i < end; ++i) ++values[static_cast<std::size_t>(i)];
  };
  pool.run(1000, 10, body);
  const std::int64_t before = test::allocation_count();
  for (int round = 0; round < 100; ++round) pool.run(1000, 10, body);
  CHECK(test::allocation_count() == before);
}

TEST_CASE("An idle ThreadPool uses no processor time", "[thread_pool]") {
  ThreadPool pool(4);
  check_coverage(pool, 100, 1);
  std::this_thread::sleep_for(std::chrono::milliseconds(50));  // past the spinning
  const std::clock_t before = std::clock();                    // of the whole process
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  CHECK(std::clock() - before < CLOCKS_PER_SEC / 20);
}

TEST_CASE("ThreadPools come and go", "[thread_pool]") {
  for (int round = 0; round < 200; ++round) {
    ThreadPool pool(1 + round % 5);
    if (round % 2 == 0) check_coverage(pool, 20, 3);
  }
}

TEST_CASE("ThreadPool reports how many threads the system allows", "[thread_pool]") {
  if (kSanitized) return;  // they reserve more address space than the limit below leaves

  // Leave address space for a few stacks only.
  std::ifstream statm("/proc/self/statm");
  rlim_t pages = 0;
  REQUIRE(statm >> pages);
  rlimit old_limit{};
  REQUIRE(getrlimit(RLIMIT_AS, &old_limit) == 0);
  rlimit limit = old_limit;
  limit.rlim_cur = pages * static_cast<rlim_t>(sysconf(_SC_PAGESIZE)) + (rlim_t{256} << 20);
  REQUIRE(setrlimit(RLIMIT_AS, &limit) == 0);
  std::string message;
  try {
    const ThreadPool pool(ThreadPool::kMaxThreads);
  } catch (const Error& error) {
    if (error.kind() == Error::kUnavailable) message = error.what();
  }
  REQUIRE(setrlimit(RLIMIT_AS, &old_limit) == 0);

  // The number of threads in the message can be had.
  INFO(message);
  const std::string lead = "number of threads is 1024; the system allows ";
  REQUIRE(message.starts_with(lead));
  const int allowed = std::stoi(message.substr(lead.size()));
  CHECK(allowed > 1);
  CHECK(allowed < 200);
  ThreadPool pool(allowed);
  check_coverage(pool, 1000, 1);
}

TEST_CASE("ThreadPool survives many short loops", "[thread_pool]") {
  // Pauses of all lengths, so that workers are met polling, asleep and in between.
  ThreadPool pool(GENERATE(2, 3, 6));
  std::vector<std::int64_t> counts(64);
  constexpr int kRounds = 60000;
  int failures = 0;
  for (int round = 0; round < kRounds; ++round) {
    const bool throws = round % 97 == 0;
    try {
      pool.run(64, 1 + round % 9, [&](int, int begin, int end) {
        for (int i = begin; i < end; ++i) ++counts[static_cast<std::size_t>(i)];
        if (throws) throw begin;
      });
    } catch (const int begin) {
      failures += begin == 0 ? 1 : 0;
    }
    if (round % 16 == 0) {
      std::this_thread::sleep_for(std::chrono::microseconds(round / 16 % 40));
    }
  }
  CHECK(counts == std::vector<std::int64_t>(64, kRounds));
  CHECK(failures == (kRounds + 96) / 97);
}

}  // namespace
}  // namespace engram
