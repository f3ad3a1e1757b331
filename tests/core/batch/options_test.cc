#include "core/batch/options.h"

#include <catch2/catch.hpp>
#include <functional>
#include <limits>
#include <type_traits>

#include "core/base/error.h"
#include "core/batch/batch.h"
#include "tests/env_helpers.h"

namespace engram {
namespace {

template <class Options>
void refuse(const std::function<void(Options&)>& change, const char* message) {
  Options options;
  change(options);
  INFO(message);
  try {
    check_ranges(options);
    FAIL("accepted");
  } catch (const Error& error) {
    CHECK(error.kind() == Error::kInvalidArgument);
    CHECK_THAT(error.what(), Catch::Contains(message));
  }
}

TEST_CASE("Options out of range are refused with what is allowed", "[options]") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  using B = BatchOptions;
  CHECK_NOTHROW(check_ranges(B()));
  refuse<B>([](B& o) { o.num_envs = 0; }, "num_envs: 0 given, 1 to 1000000 allowed");
  refuse<B>([](B& o) { o.num_envs = -5; }, "num_envs");
  refuse<B>([](B& o) { o.num_envs = 1'000'001; }, "num_envs");
  refuse<B>([](B& o) { o.threads = -1; }, "threads: -1 given");
  refuse<B>([](B& o) { o.threads = 5000; }, "threads: 5000 given");
  refuse<B>([](B& o) { o.chunk = -1; }, "chunk: -1 given");
  refuse<B>([](B& o) { o.substeps = -1; }, "substeps");
  refuse<B>([](B& o) { o.substeps = 1001; }, "substeps");
  refuse<B>([](B& o) { o.rotation_sign = 0; }, "rotation_sign: 0 given, -1 or 1 allowed");
  refuse<B>([](B& o) { o.robot_init_qpos_noise = -0.1; }, "robot_init_qpos_noise");
  refuse<B>([nan](B& o) { o.robot_init_qpos_noise = nan; }, "robot_init_qpos_noise");
  refuse<B>([infinity](B& o) { o.robot_init_qpos_noise = infinity; }, "robot_init_qpos_noise");
}

TEST_CASE("Options of the task are checked beside those of the batch", "[options]") {
  using M = MakeOptions;
  CHECK_NOTHROW(check_ranges(M()));
  refuse<M>([](M& o) { o.num_envs = 0; }, "num_envs: 0 given");
  refuse<M>([](M& o) { o.max_episode_steps = -1; }, "0 (unset) to 1000000 allowed");
  refuse<M>([](M& o) { o.max_episode_steps = 1'000'001; }, "max_episode_steps: 1000001 given");
}

TEST_CASE("A batch refuses options out of range before it has memory for them", "[options]") {
  BatchOptions options;
  options.num_envs = 1'000'001;
  CHECK_THROWS_WITH(test::make_env("RememberColor5-VLA-v0", options),
                    Catch::Contains("num_envs: 1000001 given"));
}

// It has its task, and so its constants and its horizon, already.
TEST_CASE("A batch takes no options of its task", "[options]") {
  using TaskPointer = std::unique_ptr<Task>;
  STATIC_REQUIRE(std::is_constructible_v<Batch, TaskPointer, const BatchOptions&>);
  STATIC_REQUIRE_FALSE(std::is_constructible_v<Batch, TaskPointer, const MakeOptions&>);
  STATIC_REQUIRE_FALSE(std::is_constructible_v<Batch, TaskPointer, MakeOptions>);
}

TEST_CASE("Modes say what they observe", "[options]") {
  int rows = 0;
  for (std::size_t i = 0; i < kObsModeNames.size(); ++i) {
    const auto mode = static_cast<ObsMode>(i);
    INFO(name_of(mode));
    const std::string name = name_of(mode);
    CHECK(observes_images(mode) == name.starts_with("rgb"));
    CHECK(observes_depth(mode) == (name.find("depth") != std::string::npos));
    CHECK(observes_segmentation(mode) == (name.find("segmentation") != std::string::npos));
    CHECK(observes_state(mode) == (name.find("state") != std::string::npos));
    CHECK(observes_objects(mode) == (name.find("objects") != std::string::npos));
    CHECK_FALSE((observes_state(mode) && observes_objects(mode)));
    rows += observes_state(mode) || observes_objects(mode) ? 1 : 0;
  }
  CHECK(rows == 12);
}

}  // namespace
}  // namespace engram
