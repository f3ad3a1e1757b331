// Sheets of `engram record`: which steps they show.
#include "apps/record_sheet.h"

#include <catch2/catch.hpp>

#include "protocol/make/make.h"

namespace engram::apps {
namespace {

using Steps = std::vector<int>;

TEST_CASE("Sheets show both ends, changes of phase, and steps between them", "[apps]") {
  const Steps changes = {5, 10};
  CHECK(sheet_steps(1, 25, changes) == Steps{25});
  CHECK(sheet_steps(2, 25, changes) == Steps{0, 25});
  CHECK(sheet_steps(3, 25, changes) == Steps{0, 5, 25});
  CHECK(sheet_steps(6, 25, changes) == Steps{0, 5, 10, 17, 21, 25});
  CHECK(sheet_steps(3, 60, {}) == Steps{0, 30, 60});
}

TEST_CASE("Sheets have no step twice and none beyond the end", "[apps]") {
  const Steps changes = {5, 5, 40};
  CHECK(sheet_steps(4, 25, changes) == Steps{0, 5, 15, 25});
  CHECK(sheet_steps(60, 3, changes) == Steps{0, 1, 2, 3});
  CHECK(sheet_steps(60, 0, changes) == Steps{0});
}

TEST_CASE("Phases of drawn lengths end at their steps", "[apps]") {
  const auto changes_of = [](const char* id, ConstantTable constants) {
    const auto batch = make(id, {{}, std::move(constants)});
    batch->reset();
    return phase_changes(*batch);
  };
  const ConstantTable lengths = {{"CUE_PHASE_STEPS", ConstantList{3, 3}},
                                 {"EMPTY_PHASE_STEPS", ConstantList{2, 2}}};
  CHECK(changes_of("RememberColor3-VLA-v0", lengths) == Steps{3, 5});
  CHECK(changes_of("RotateLenientPos-VLA-v0", {}).empty());
}

}  // namespace
}  // namespace engram::apps
