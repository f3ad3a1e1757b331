// Constants without effect, and constants with which the oracle fails, are warned of. Under the
// rules of the original's code the colour families touch within CUBE_HALFSIZE, so
// GOAL_THRESH has no effect there.
#include <catch2/catch.hpp>

#include "core/batch/queries.h"
#include "protocol/make/constant_warnings.h"
#include "protocol/make/make.h"
#include "protocol/make/task_description.h"

namespace engram {
namespace {

using Catch::Contains;
using Warnings = std::vector<std::string>;

constexpr const char* kIds[] = {"BunchOfColors3-VLA-v0", "SeqOfColors3-VLA-v0",
                                "ChainOfColors3-VLA-v0"};
const std::string kWarning =
    "GOAL_THRESH=0.08 has no effect on touch_radius, which is 0.02 with rules=original; the option "
    "touch_radius sets it";

MakeOptions options_of(Rules rules, ConstantTable constants) {
  MakeOptions options{{.rules = rules}, std::move(constants)};
  return options;
}

TEST_CASE("GOAL_THRESH without effect is warned of by name", "[rules][constants]") {
  for (const char* id : kIds) {
    INFO(id);
    const MakeOptions options = options_of(Rules::kOriginal, {{"GOAL_THRESH", 0.08}});
    CHECK(constant_warnings(id, options) == Warnings{kWarning});
    const auto batch = make(id, options);
    CHECK(Queries(*batch).option_values()[0] == 0.02);
    CHECK((part(Json(describe_task(*batch)), "warnings") == Json(ConstantList{kWarning})));
  }
}

TEST_CASE("Nothing is warned of that has an effect", "[rules][constants]") {
  for (const char* id : kIds) {
    INFO(id);
    const ConstantTable threshold = {{"GOAL_THRESH", 0.08}};
    CHECK(constant_warnings(id, options_of(Rules::kReference, threshold)).empty());
    CHECK(constant_warnings(id, options_of(Rules::kOriginal, {})).empty());
    CHECK(constant_warnings(id, options_of(Rules::kOriginal, {{"CUBE_HALFSIZE", 0.018}})).empty());
    CHECK(constant_warnings(id, options_of(Rules::kOriginal, {{"COLORS", 8}})).empty());
  }
  CHECK(constant_warnings("RememberColor3-VLA-v0",
                          options_of(Rules::kOriginal, {{"GOAL_THRESH", 0.04}}))
            .empty());
}

TEST_CASE("A user who chooses touch_radius is not warned", "[rules][constants]") {
  MakeOptions options = options_of(Rules::kOriginal, {{"GOAL_THRESH", 0.08}});
  options.task_options = {{"touch_radius", 0.08}};
  CHECK(constant_warnings(kIds[0], options).empty());
}

TEST_CASE("The warning names the radius that counts", "[rules][constants]") {
  const ConstantTable both = {{"CUBE_HALFSIZE", 0.018}, {"GOAL_THRESH", 0.03}};
  const Warnings warnings = constant_warnings(kIds[1], options_of(Rules::kOriginal, both));
  REQUIRE(warnings.size() == 1);
  CHECK_THAT(warnings[0], Contains("GOAL_THRESH=0.03") && Contains("is 0.018"));
}

TEST_CASE("Values with which the oracle fails are warned of", "[constants]") {
  const auto warned = [](const char* id, ConstantTable constants) {
    return constant_warnings(id, options_of(Rules::kReference, std::move(constants)));
  };
  constexpr const char* kColor = "RememberColor3-VLA-v0";
  constexpr const char* kBall = "InterceptSlow-VLA-v0";
  CHECK(warned(kColor, {{"GOAL_THRESH", 0.005}}) ==
        Warnings{"GOAL_THRESH=0.005 is below 0.01, where the oracle itself may fail; measure it "
                 "beside your policy"});
  CHECK(warned("FindImposterShape5-VLA-v0", {{"GOAL_THRESH", 0.008}}).size() == 1);
  const Warnings of_range = warned(kBall, {{"VELOCITY_RANGE", ConstantList{0.0, 0.3}}});
  REQUIRE(of_range.size() == 1);
  CHECK_THAT(of_range[0], Contains("VELOCITY_RANGE=[0, 0.3] begins below 0.1"));
  CHECK(warned(kColor, {{"GOAL_THRESH", 0.01}}).empty());
  CHECK(warned(kBall, {{"VELOCITY_RANGE", ConstantList{0.25, 0.5}}}).empty());
  CHECK(warned("ShellGamePush-VLA-v0", {}).empty());
}

TEST_CASE("Variants are warned of, too", "[rules][constants][variants]") {
  const TaskVariant variant = {
      .id = "Unused-Threshold-v0", .base = kIds[2], .constants = {{"GOAL_THRESH", 0.08}}};
  register_variants({&variant, 1});
  CHECK(constant_warnings(variant.id, options_of(Rules::kOriginal, {})) == Warnings{kWarning});
  CHECK(constant_warnings(variant.id, options_of(Rules::kReference, {})).empty());
}

}  // namespace
}  // namespace engram
