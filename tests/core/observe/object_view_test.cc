#include "core/observe/object_view.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <string>

#include "core/batch/queries.h"
#include "tests/env_helpers.h"

namespace engram {
namespace {

using Layout = ObjectTokens::Layout;

std::unique_ptr<Batch> make_seeing(std::string_view id, BatchOptions options) {
  options.obs_mode = ObsMode::kObjects;
  return test::make_running(id, options);
}

TEST_CASE("A row is the robot, the cue where there is one, the time if asked for, and the tokens",
          "[objects]") {
  const auto names = [](const char* id, bool time) {
    const BatchOptions options{.observe_time = time};
    const auto batch = make_seeing(id, options);
    std::vector<std::string> parts;
    for (const Field& field : Queries(*batch).state_fields()) {
      if (field.name.starts_with("object_")) break;
      parts.push_back(field.name);
    }
    return parts;
  };
  using Names = std::vector<std::string>;
  CHECK(names("RememberColor3-VLA-v0", false) == Names{"qpos", "qvel", "tcp_pose"});
  CHECK(names("RememberColor3-VLA-v0", true) == Names{"qpos", "qvel", "tcp_pose", "time"});
  CHECK(names("RotateLenientPos-VLA-v0", false) == Names{"qpos", "qvel", "tcp_pose", "task_cue"});
}

TEST_CASE("Ranges are those of the fields, and other modes have none", "[objects]") {
  const auto batch = make_seeing("RememberColor3-VLA-v0", {});
  const Queries queries(*batch);
  const std::span<const RangedField> ranged = queries.ranged_fields();
  REQUIRE(ranged.size() == Queries(*batch).state_fields().size());
  for (std::size_t i = 0; i < ranged.size(); ++i) {
    CHECK(ranged[i].field.name == Queries(*batch).state_fields()[i].name);
    CHECK(ranged[i].low < ranged[i].high);
  }
  CHECK(Queries(*test::make_env("RememberColor3-VLA-v0")).ranged_fields().empty());
}

TEST_CASE("The last observation of an episode is kept", "[objects]") {
  const BatchOptions options{
      .num_envs = 3, .observe_time = true, .auto_reset = AutoReset::kSameStep};
  const auto batch = make_seeing("RememberColor3-VLA-v0", options);
  for (int t = 0; t < 25; ++t) test::step(*batch, Policy::kRandom);
  REQUIRE(batch->outputs().final_mask[0] == 1);
  const auto* last = test::row<float>(batch->final_output("observation"), 1);
  const auto* first = test::row<float>(batch->output("observation"), 1);
  CHECK(last[25] == 1);
  CHECK(first[25] == 0);
  CHECK(first[25 + 1] + first[25 + 1 + Layout::kWidth] + first[25 + 1 + 2 * Layout::kWidth] == 1);
}

TEST_CASE("A row that is no row of numbers ends the episode", "[objects]") {
  const BatchOptions options{.auto_reset = AutoReset::kOff};
  const auto batch = make_seeing("RotateLenientPos-VLA-v0", options);
  test::step(*batch, Policy::kZero);
  CHECK(batch->outputs().unstable[0] == 0);
  *reinterpret_cast<double*>(test::memory_of(*batch).find("target_angle").row(0)) = std::nan("");
  test::step(*batch, Policy::kZero);
  CHECK(batch->outputs().unstable[0] == 1);
  CHECK(batch->outputs().truncated[0] == 1);
}

}  // namespace
}  // namespace engram
