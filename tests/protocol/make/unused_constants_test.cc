// Under the rules of the original's code the colour families touch within CUBE_HALFSIZE, so
// GOAL_THRESH has no effect there.
#include "protocol/make/unused_constants.h"

#include <catch2/catch.hpp>

#include "core/batch/queries.h"
#include "protocol/make/make.h"
#include "protocol/make/task_description.h"

namespace engram {
namespace {

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
    CHECK(unused_constants(id, options) == Warnings{kWarning});
    const auto batch = make(id, options);
    CHECK(Queries(*batch).option_values()[0] == 0.02);
    CHECK((part(Json(describe_task(*batch)), "warnings") == Json(ConstantList{kWarning})));
  }
}

TEST_CASE("Nothing is warned of that has an effect", "[rules][constants]") {
  for (const char* id : kIds) {
    INFO(id);
    const ConstantTable threshold = {{"GOAL_THRESH", 0.08}};
    CHECK(unused_constants(id, options_of(Rules::kReference, threshold)).empty());
    CHECK(unused_constants(id, options_of(Rules::kOriginal, {})).empty());
    CHECK(unused_constants(id, options_of(Rules::kOriginal, {{"CUBE_HALFSIZE", 0.018}})).empty());
    CHECK(unused_constants(id, options_of(Rules::kOriginal, {{"COLORS", 8}})).empty());
  }
  CHECK(unused_constants("RememberColor3-VLA-v0",
                         options_of(Rules::kOriginal, {{"GOAL_THRESH", 0.04}}))
            .empty());
}

TEST_CASE("A user who chooses touch_radius is not warned", "[rules][constants]") {
  MakeOptions options = options_of(Rules::kOriginal, {{"GOAL_THRESH", 0.08}});
  options.task_options = {{"touch_radius", 0.08}};
  CHECK(unused_constants(kIds[0], options).empty());
}

TEST_CASE("The warning names the radius that counts", "[rules][constants]") {
  const ConstantTable both = {{"CUBE_HALFSIZE", 0.018}, {"GOAL_THRESH", 0.03}};
  const Warnings warnings = unused_constants(kIds[1], options_of(Rules::kOriginal, both));
  REQUIRE(warnings.size() == 1);
  CHECK_THAT(warnings[0], Catch::Contains("GOAL_THRESH=0.03") && Catch::Contains("is 0.018"));
}

TEST_CASE("Variants are warned of, too", "[rules][constants][variants]") {
  const TaskVariant variant = {
      .id = "Unused-Threshold-v0", .base = kIds[2], .constants = {{"GOAL_THRESH", 0.08}}};
  register_variants({&variant, 1});
  CHECK(unused_constants(variant.id, options_of(Rules::kOriginal, {})) == Warnings{kWarning});
  CHECK(unused_constants(variant.id, options_of(Rules::kReference, {})).empty());
}

}  // namespace
}  // namespace engram
