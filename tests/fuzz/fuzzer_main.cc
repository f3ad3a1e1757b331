// Entry point of libFuzzer: one program per target (cmake/EngramFuzz.cmake).
#include "tests/fuzz/input.h"

// NOLINTNEXTLINE(readability-identifier-naming): the name is libFuzzer's
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  engram::fuzz::ENGRAM_FUZZ_TARGET({data, size});
  return 0;
}
