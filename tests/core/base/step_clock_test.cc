#include "core/base/step_clock.h"

#include <catch2/catch.hpp>

namespace engram {
namespace {

constexpr auto index_of(StepPart part) { return static_cast<std::size_t>(part); }

TEST_CASE("A clock counts marks and time by part, over all workers", "[step_clock]") {
  StepClock clock(2);
  for (int worker = 0; worker < 2; ++worker) {
    clock.worker(worker).start();
    mark(&clock.worker(worker), StepPart::kTask);
    mark(&clock.worker(worker), StepPart::kDynamics);
    mark(&clock.worker(worker), StepPart::kTask);
  }
  CHECK(clock.marks()[index_of(StepPart::kTask)] == 4);
  CHECK(clock.marks()[index_of(StepPart::kDynamics)] == 2);
  CHECK(clock.marks()[index_of(StepPart::kRender)] == 0);
  CHECK(clock.ticks()[index_of(StepPart::kRender)] == 0);
  CHECK(clock.worker(0).marks()[index_of(StepPart::kTask)] == 2);
}

TEST_CASE("Parts share the time between start and the last mark", "[step_clock]") {
  StepClock clock(1);
  const std::uint64_t before = StepClock::now();
  clock.worker(0).start();
  for (int i = 0; i < 1000; ++i) clock.worker(0).mark(StepPart::kWake);
  clock.worker(0).mark(StepPart::kReset);
  const std::uint64_t passed = StepClock::now() - before;
  const StepClock::Ticks ticks = clock.ticks();
  const std::uint64_t counted =
      ticks[index_of(StepPart::kWake)] + ticks[index_of(StepPart::kReset)];
  CHECK(counted > 0);
  CHECK(counted <= passed);
}

}  // namespace
}  // namespace engram
