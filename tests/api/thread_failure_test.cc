// Threads that the system refuses: the call says so, and the threads that were started are gone.
#include "tests/thread_failure.h"

#include <chrono>
#include <filesystem>
#include <thread>

#include "core/threads/processors.h"
#include "tests/api/c_api_fixture.h"

namespace engram {
namespace {

using test::BatchHandle, test::FailingThread;

std::ptrdiff_t threads_of_this_process() {
  return std::distance(std::filesystem::directory_iterator("/proc/self/task"), {});
}

// A sanitizer starts one of its own with the first, which is not one of engram's.
std::ptrdiff_t threads_at_the_start() {
  std::thread([] {}).join();
  return threads_of_this_process();
}

// Joined threads may still be listed for a moment, so more than `number` is given time to go.
bool threads_fall_to(std::ptrdiff_t number) {
  for (int attempt = 0; attempt < 1000 && threads_of_this_process() > number; ++attempt) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return threads_of_this_process() <= number;
}

TEST_CASE("C API: a batch whose threads are refused is not made", "[api][fault]") {
  engram_options options = test::default_options(8);
  options.threads = 4;
  const int threads = usable_processors();
  const std::ptrdiff_t before = threads_at_the_start();
  for (int number = 1; number < threads; ++number) {
    engram_env* env = nullptr;
    const FailingThread failing(number);
    const std::string allowed = "number of threads is " + std::to_string(threads) +
                                "; the system allows " + std::to_string(number);
    test::check_refused(engram_make(test::kId, &options, &env), ENGRAM_UNAVAILABLE,
                        allowed.c_str());
    CHECK(env == nullptr);
    CHECK(threads_fall_to(before));
  }
  {
    const BatchHandle first = test::make_batch(options);
    CHECK(threads_of_this_process() == before + threads - 1);
    const FailingThread failing(1);  // further batches start none
    test::make_batch(options).reset();
  }
  CHECK(threads_fall_to(before));
}

TEST_CASE("C API: without a thread of its own a batch still steps", "[api][fault]") {
  const BatchHandle batch = test::make_running(test::default_options(1));
  const std::vector<float> actions(7);
  {
    const FailingThread failing(1);
    CHECK(engram_step_async(batch.get(), actions.data(), 7) == ENGRAM_UNAVAILABLE);
  }
  CHECK(engram_step_wait(batch.get()) == ENGRAM_BAD_STATE);
  CHECK(engram_step(batch.get(), actions.data(), 7) == ENGRAM_OK);
  CHECK(engram_step_async(batch.get(), actions.data(), 7) == ENGRAM_OK);
  CHECK(engram_step_wait(batch.get()) == ENGRAM_OK);
}

TEST_CASE("C API: an evaluation whose threads are refused ends with that", "[api][fault]") {
  engram_evaluation_options options = test::evaluation_options(3);
  options.num_envs = 1;
  options.threads = 3;
  const auto refuse = [](void*, const engram_policy_request*, engram_policy_reply*) { return 1; };
  const std::ptrdiff_t before = threads_at_the_start();
  for (int number = 1; number <= 3; ++number) {
    char* document = nullptr;
    const FailingThread failing(number);
    test::check_refused(engram_evaluate(&options, refuse, nullptr, &document), ENGRAM_UNAVAILABLE,
                        "threads: 3 given, the system allows");
    CHECK(document == nullptr);
    CHECK(threads_fall_to(before));
  }
}

}  // namespace
}  // namespace engram
