// What becomes of a function whose allocations fail, one in each run.
#pragma once

#include <catch2/catch.hpp>
#include <cstdint>
#include <new>

#include "tests/allocation_counter.h"

namespace engram::test {

inline constexpr std::int64_t kEveryAllocation = 1'000'000;

// Runs the function with each of its allocations failing in turn: it must throw std::bad_alloc and
// leak nothing. `check` is called after each run. Of allocations after the first `all`, every ninth
// fails. Returns how many allocations there are, up to eight more.
template <class F, class Check>
std::int64_t fails_well_everywhere(F&& run, Check&& check, std::int64_t all = kEveryAllocation) {
  for (std::int64_t number = 1;; number += number < all ? 1 : 9) {
    const std::int64_t before = outstanding_allocations();
    bool refused = false;
    bool happened = false;
    try {
      const FailingAllocation failing(number);
      run();
      happened = FailingAllocation::happened();
    } catch (const std::bad_alloc&) {
      refused = happened = true;
    }
    const std::int64_t leaked = outstanding_allocations() - before;  // INFO allocates
    INFO("allocation " << number);
    CHECK(refused == happened);
    CHECK(leaked == 0);
    check();
    if (!happened) return number - 1;
  }
}

template <class F>
std::int64_t fails_well_everywhere(F&& run, std::int64_t all = kEveryAllocation) {
  return fails_well_everywhere(
      run, [] {}, all);
}

}  // namespace engram::test
