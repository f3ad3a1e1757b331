// Counts the allocations that C++ code makes, for tests of what must not allocate.
#pragma once

#include <cstdint>

namespace engram::test {

// Calls of operator new by all threads since the program started.
std::int64_t allocation_count() noexcept;

}  // namespace engram::test
