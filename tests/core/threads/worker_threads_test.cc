#include "core/threads/worker_threads.h"

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <catch2/catch.hpp>
#include <chrono>
#include <cstdint>
#include <ctime>
#include <fstream>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "core/base/error.h"
#include "core/threads/thread_pool.h"
#include "tests/sanitizers.h"

namespace engram {
namespace {

using test::kSanitized;

// A loop shared by all threads, whatever it costs.
template <class F>
std::exception_ptr run_shared(WorkerThreads& threads, int items, int chunk, const F& f) {
  const LoopWork::Body body = [](const void* context, int worker, int begin, int end) {
    (*static_cast<const F*>(context))(worker, begin, end);
  };
  std::int64_t busy = 0;
  return threads.run({body, &f, items, chunk, 1, threads.helpers() + 1}, &busy);
}

TEST_CASE("Every worker of a loop is a thread of its own, the caller being worker 0",
          "[worker_threads]") {
  constexpr int kThreads = 4;
  WorkerThreads threads(kThreads - 1);
  std::vector<std::thread::id> ids(kThreads);
  std::atomic<int> arrived = 0;
  // Nobody leaves before all have come, so each of them gets one range.
  run_shared(threads, kThreads, 1, [&](int worker, int, int) {
    ids[static_cast<std::size_t>(worker)] = std::this_thread::get_id();
    ++arrived;
    while (arrived < kThreads) std::this_thread::yield();
  });
  CHECK(ids[0] == std::this_thread::get_id());
  CHECK(std::set<std::thread::id>(ids.begin(), ids.end()).size() == kThreads);
}

TEST_CASE("A loop takes no more threads than it asks for", "[worker_threads]") {
  WorkerThreads threads(7);
  std::atomic<int> most = 0;
  const auto body = [&](int worker, int, int) {
    int seen = most;
    while (seen < worker && !most.compare_exchange_weak(seen, worker)) continue;
    std::this_thread::sleep_for(std::chrono::microseconds(50));
  };
  const LoopWork::Body call = [](const void* context, int worker, int begin, int end) {
    (*static_cast<decltype(body)*>(context))(worker, begin, end);
  };
  std::int64_t busy = 0;
  for (int round = 0; round < 20; ++round) threads.run({call, &body, 40, 1, 1, 3}, &busy);
  CHECK(most == 2);
  CHECK(busy >= 40 * 50'000);
}

TEST_CASE("Idle worker threads use no processor time", "[worker_threads]") {
  WorkerThreads threads(3);
  run_shared(threads, 100, 1, [](int, int, int) {});
  std::this_thread::sleep_for(std::chrono::milliseconds(50));  // past the polling
  const std::clock_t before = std::clock();                    // of the whole process
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  CHECK(std::clock() - before < CLOCKS_PER_SEC / 20);
}

TEST_CASE("A loop ends without the threads that sleep", "[worker_threads]") {
  // One helper is kept busy by another loop; this one must not wait for it.
  WorkerThreads threads(1);
  std::atomic<bool> held = false;
  std::atomic<bool> let_go = false;
  std::thread other([&] {
    run_shared(threads, 2, 1, [&](int worker, int, int) {
      if (worker == 1) held = true;
      while (!let_go) std::this_thread::yield();
    });
  });
  while (!held) std::this_thread::yield();
  std::atomic<int> items = 0;
  run_shared(threads, 100, 1, [&](int worker, int begin, int end) {
    if (worker == 0) items += end - begin;
  });
  CHECK(items == 100);
  let_go = true;
  other.join();
}

TEST_CASE("All pools of a process share its threads", "[worker_threads]") {
  const auto first = WorkerThreads::of_process();
  CHECK(first->helpers() < static_cast<int>(std::thread::hardware_concurrency()));
  std::vector<std::unique_ptr<ThreadPool>> pools;
  for (int i = 0; i < 97; ++i) pools.push_back(std::make_unique<ThreadPool>(2));
  CHECK(WorkerThreads::of_process() == first);
}

TEST_CASE("A forked process has threads of its own", "[worker_threads]") {
  if (kSanitized) return;  // ThreadSanitizer forks no process with threads
  const auto ours = WorkerThreads::of_process();
  const pid_t child = ::fork();
  if (child == 0) {
    const auto theirs = WorkerThreads::of_process();
    std::atomic<int> items = 0;
    run_shared(*theirs, 1000, 1, [&](int, int begin, int end) { items += end - begin; });
    ::_exit(theirs != ours && items == 1000 ? 0 : 1);
  }
  REQUIRE(child > 0);
  int status = -1;
  REQUIRE(::waitpid(child, &status, 0) == child);
  CHECK(status == 0);
}

TEST_CASE("Worker threads report how many the system allows", "[worker_threads]") {
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
    const WorkerThreads threads(WorkerThreads::kMaxThreads - 1);
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
  CHECK(WorkerThreads(allowed - 1).helpers() == allowed - 1);
}

TEST_CASE("Worker threads refuse numbers out of range", "[worker_threads]") {
  for (const int helpers : {-1, WorkerThreads::kMaxThreads}) {
    CHECK_THROWS_WITH(WorkerThreads(helpers), Catch::Contains(std::to_string(helpers + 1)));
  }
}

TEST_CASE("Many short loops of many callers are all done", "[worker_threads]") {
  // Pauses of all lengths, so that workers are met polling, asleep and in between.
  WorkerThreads threads(GENERATE(1, 5, 63));
  constexpr int kRounds = 20000;
  constexpr int kCallers = 3;
  std::atomic<int> wrong = 0;
  const auto call_loops = [&](int caller) {
    std::vector<std::int64_t> counts(64);
    int failures = 0;
    for (int round = 0; round < kRounds; ++round) {
      const bool throws = round % 97 == 0;
      const std::exception_ptr error =
          run_shared(threads, 64, 1 + round % 9, [&](int, int begin, int end) {
            for (int i = begin; i < end; ++i) ++counts[static_cast<std::size_t>(i)];
            if (throws) throw begin;
          });
      if (error != nullptr) ++failures;
      if (round % 16 == caller) {
        std::this_thread::sleep_for(std::chrono::microseconds(round / 16 % 40));
      }
    }
    if (counts != std::vector<std::int64_t>(64, kRounds)) ++wrong;
    if (failures != (kRounds + 96) / 97) ++wrong;
  };
  std::vector<std::thread> callers;
  for (int caller = 0; caller < kCallers; ++caller) callers.emplace_back(call_loops, caller);
  for (std::thread& caller : callers) caller.join();
  CHECK(wrong == 0);
}

}  // namespace
}  // namespace engram
