#include "core/threads/process_mutex.h"

#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <catch2/catch.hpp>
#include <thread>

namespace engram {
namespace {

TEST_CASE("a child of fork finds no shared lock taken by a thread that it lacks") {
  std::atomic<bool> taken = false;
  std::atomic<bool> given_back = false;
  std::thread other([&] {
    const std::scoped_lock lock(process_mutex(ProcessLock::kCompiler),
                                process_mutex(ProcessLock::kModels));
    taken = true;
    usleep(50'000);  // fork is called meanwhile
    given_back = true;
  });
  while (!taken) std::this_thread::yield();
  const pid_t child = fork();
  if (child == 0) {
    bool all_free = given_back;
    for (int i = 0; i <= static_cast<int>(ProcessLock::kModels); ++i) {
      all_free = process_mutex(static_cast<ProcessLock>(i)).try_lock() && all_free;
    }
    // Past _exit, where a sanitizer would call the parent's thread a leak of the child's.
    syscall(SYS_exit_group, all_free ? 0 : 1);
  }
  other.join();
  REQUIRE(child > 0);
  int status = -1;
  REQUIRE(waitpid(child, &status, 0) == child);
  CHECK(WIFEXITED(status));
  CHECK(WEXITSTATUS(status) == 0);
  for (int i = 0; i <= static_cast<int>(ProcessLock::kModels); ++i) {
    std::mutex& lock = process_mutex(static_cast<ProcessLock>(i));
    REQUIRE(lock.try_lock());
    lock.unlock();
  }
}

}  // namespace
}  // namespace engram
