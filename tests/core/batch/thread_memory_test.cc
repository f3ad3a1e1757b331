// What a thread's working memory takes up. Measured in processes of their own: what others have
// left free would be used first.
#include <unistd.h>

#include <catch2/catch.hpp>
#include <cstdlib>
#include <fstream>
#include <string>

#include "tests/env_helpers.h"
#include "tests/own_process.h"
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

// Not for itself: what the other one runs in processes of their own.
TEST_CASE("Bytes of a process that has played", "[.][print_memory]") {
  const char* id = std::getenv("ENGRAM_TEST_ID");
  const char* threads = std::getenv("ENGRAM_TEST_THREADS");
  if (id == nullptr || threads == nullptr) return;
  const auto batch =
      test::make_running(id, {.num_envs = 36, .threads = std::atoi(threads), .chunk = 1});
  for (int i = 0; i < 40; ++i) test::step(*batch, i % 2 == 0 ? Policy::kOracle : Policy::kRandom);
  std::printf("bytes %f\n", resident_bytes());
}

double bytes_with(const std::string& id, int threads) {
  const std::string environment =
      "ENGRAM_TEST_ID=" + id + " ENGRAM_TEST_THREADS=" + std::to_string(threads);
  for (const std::string& line : test::lines_of_own_process("print_memory", environment)) {
    if (line.starts_with("bytes ")) return std::stod(line.substr(6));
  }
  FAIL("nothing printed");
  return 0;
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
