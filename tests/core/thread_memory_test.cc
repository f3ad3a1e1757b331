// What a thread's working memory takes up. Measured in processes of their own: what others have
// left free would be used first.
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <fstream>
#include <string>

#include "tests/env_helpers.h"
#include "tests/sanitizers.h"

namespace engram {
namespace {

double resident_bytes() {
  std::ifstream file("/proc/self/statm");
  double total = 0;
  double resident = 0;
  file >> total >> resident;
  return resident * static_cast<double>(sysconf(_SC_PAGESIZE));
}

// Resident bytes of a process that has played with a batch of that many threads.
double bytes_with(const std::string& id, int threads) {
  int ends[2];
  REQUIRE(pipe(ends) == 0);
  const pid_t child = fork();
  REQUIRE(child >= 0);
  if (child == 0) {
    EnvOptions options;
    options.num_envs = 36;
    options.threads = threads;
    options.chunk = 1;
    const auto env = test::make_env(id, options);
    env->reset();
    for (int i = 0; i < 40; ++i) test::step(*env, i % 2 == 0 ? Policy::kOracle : Policy::kRandom);
    const double bytes = resident_bytes();
    const bool written = write(ends[1], &bytes, sizeof bytes) == sizeof bytes;
    _exit(written ? 0 : 1);
  }
  double bytes = 0;
  REQUIRE(read(ends[0], &bytes, sizeof bytes) == sizeof bytes);
  int status = 0;
  REQUIRE(waitpid(child, &status, 0) == child);
  REQUIRE(status == 0);
  close(ends[0]);
  close(ends[1]);
  return bytes;
}

TEST_CASE("A thread takes up less than two megabytes", "[memory]") {
  if (test::kSanitized) return;  // with a heap of its own
  constexpr int kMore = 17;
  for (const char* id : {"RememberColor9-VLA-v0", "BatteriesCheckerEasy-15-VLA-v0",
                         "RememberShapeAndColor5x3-VLA-v0", "InterceptGrabFast-VLA-v0"}) {
    CAPTURE(id);
    CHECK((bytes_with(id, 1 + kMore) - bytes_with(id, 1)) / kMore < 2e6);
  }
}

}  // namespace
}  // namespace engram
