#include "apps/task_text.h"

#include <catch2/catch.hpp>
#include <string>

#include "protocol/make/make.h"
#include "protocol/make/task_description.h"

namespace engram::apps {
namespace {

TEST_CASE("The text of a task has a section for each part of its description", "[apps]") {
  const auto batch = make("RememberColor9-VLA-v0", {.num_envs = 1, .threads = 1});
  const std::string text = task_text(describe_task(*batch));
  CHECK(text.starts_with("RememberColor9-VLA-v0: "));
  for (const char* section : {"Answer", "Phases", "Drawn per episode", "Props", "Actions",
                              "Observation", "Proprio", "Outputs", "Reward", "Constants"}) {
    INFO(section);
    CHECK_THAT(text, Catch::Contains("\n" + std::string(section)));
  }
  CHECK_THAT(text, Catch::Contains("cue_steps") && Catch::Contains("pd_ee_delta_pose"));
}

}  // namespace
}  // namespace engram::apps
