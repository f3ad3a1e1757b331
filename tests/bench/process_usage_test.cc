#include "bench/process_usage.h"

#include <fcntl.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <vector>

#include "tests/sanitizers.h"

namespace engram::bench {
namespace {

TEST_CASE("An open descriptor is counted", "[bench]") {
  const int before = process_usage().descriptors;
  const int descriptor = open("/dev/null", O_RDONLY);
  CHECK(process_usage().descriptors == before + 1);
  close(descriptor);
  CHECK(process_usage().descriptors == before);
}

TEST_CASE("Memory in use is counted", "[bench]") {
  if (test::kSanitized) return;
  const double before = allocated_bytes();
  const std::vector<char> block(10'000'000, 'x');
  CHECK(allocated_bytes() >= before + 10e6);
  CHECK(process_usage().threads >= 1);
  CHECK(process_usage().resident_bytes > 10e6);
}

}  // namespace
}  // namespace engram::bench
