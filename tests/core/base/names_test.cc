// Enums and the names of their values.
#include "core/base/names.h"

#include <catch2/catch.hpp>
#include <set>
#include <string>

#include "core/batch/options.h"

namespace engram {
namespace {

using Catch::Contains;

template <class Enum>
void check_names() {
  const auto& names = names_of(Enum());
  CHECK(std::set<std::string>(names.begin(), names.end()).size() == names.size());
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto value = static_cast<Enum>(i);
    CHECK(find_named<Enum>(name_of(value)) == value);
    CHECK(require_named<Enum>("mode", name_of(value)) == value);
  }
}

TEST_CASE("Every value of an enum has a name of its own", "[names]") {
  check_names<ObsMode>();
  check_names<RewardMode>();
  check_names<AutoReset>();
  check_names<Policy>();
  check_names<ControlMode>();
  CHECK(std::string(name_of(ObsMode::kStateDict)) == "state_dict");
  CHECK(std::string(name_of(AutoReset::kSameStep)) == "same-step");
}

TEST_CASE("Unknown names are refused with those that exist", "[names]") {
  CHECK_FALSE(find_named<ObsMode>("").has_value());
  CHECK_FALSE(find_named<ObsMode>("rgbd").has_value());
  CHECK_THROWS_WITH(require_named<AutoReset>("auto-reset", "on"),
                    Contains("no auto-reset named 'on'") && Contains("next-step, same-step, off"));
}

}  // namespace
}  // namespace engram
