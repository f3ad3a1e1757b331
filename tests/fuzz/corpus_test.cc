// The fuzz targets on what fuzzing has found worth keeping: tests/data/fuzz/<target>/.
#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <vector>

#include "tests/build_paths.h"
#include "tests/fuzz/targets.h"
#include "tests/sanitizers.h"

namespace engram {
namespace {

TEST_CASE("Fuzz targets: their corpora", "[fuzz]") {
  // Batches of the C API's target, and their threads, last until the process ends.
  const test::ForgivenLeaks forgiven;
  for (const fuzz::Target& target : fuzz::kTargets) {
    const std::filesystem::path folder = std::filesystem::path(test::kData) / "fuzz" / target.name;
    int files = 0;
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
      std::ifstream file(entry.path(), std::ios::binary);
      const std::vector<char> bytes{std::istreambuf_iterator<char>(file), {}};
      const auto* data = reinterpret_cast<const std::uint8_t*>(bytes.data());
      INFO(entry.path().string());
      CHECK_NOTHROW(target.run({data, bytes.size()}));
      ++files;
    }
    INFO(target.name);
    CHECK(files > 0);
  }
}

}  // namespace
}  // namespace engram
