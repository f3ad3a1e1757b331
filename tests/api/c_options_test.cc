#include "api/c_options.h"

#include <catch2/catch.hpp>

#include "core/base/error.h"

namespace engram::c {
namespace {

using Catch::Contains;

// Every option that api/surface.toml lists has one default in C and in the engine.
TEST_CASE("Default options of C are those of the engine", "[c_options]") {
  const MakeOptions converted = to_make_options(default_options());
  const MakeOptions own;
  CHECK(converted.num_envs == own.num_envs);
  CHECK(converted.seed == own.seed);
  CHECK(converted.obs_mode == own.obs_mode);
  CHECK(converted.reward_mode == own.reward_mode);
  CHECK(converted.control_mode == own.control_mode);
  CHECK(converted.auto_reset == own.auto_reset);
  CHECK(converted.after_end == own.after_end);
  CHECK(converted.terminate_on_success == own.terminate_on_success);
  CHECK(converted.terminate_on_failure == own.terminate_on_failure);
  CHECK(converted.robot_init_qpos_noise == own.robot_init_qpos_noise);
  CHECK(converted.substeps == own.substeps);
  CHECK(converted.rules == own.rules);
  CHECK(converted.constants == own.constants);
  CHECK(converted.max_episode_steps == own.max_episode_steps);
  CHECK(converted.images.cameras == own.images.cameras);
  CHECK(converted.images.width == own.images.width);
  CHECK(converted.image_options.renderer == own.image_options.renderer);
}

TEST_CASE("Options of C reach the engine's", "[c_options]") {
  engram_options options = default_options();
  options.num_envs = 7;
  options.terminate_on_success = 0;
  options.obs_mode = ENGRAM_OBS_RGB_DEPTH;
  options.constants = R"({"COLORS": 3})";
  options.max_episode_steps = 21;
  const char* const cameras[] = {"hand_camera"};
  options.cameras = cameras;
  options.num_cameras = 1;
  const MakeOptions converted = to_make_options(options);
  CHECK(converted.num_envs == 7);
  CHECK(converted.terminate_on_success == std::optional<bool>(false));
  CHECK(converted.obs_mode == ObsMode::kRgbDepth);
  CHECK((converted.constants == ConstantTable{{"COLORS", 3}}));
  CHECK(converted.max_episode_steps == 21);
  CHECK(converted.images.cameras == std::vector<std::string>{"hand_camera"});
}

TEST_CASE("Pins, choices and numbers that stand for names are converted or refused",
          "[c_options]") {
  const double values[] = {1, 2};
  const engram_pin pin = {"target", values, 2};
  const std::vector<Pin> pins = to_pins(&pin, 1);
  REQUIRE(pins.size() == 1);
  CHECK(pins[0].name == "target");
  CHECK(pins[0].values == std::vector<double>{1, 2});
  CHECK_THROWS_WITH(to_pins(nullptr, 2), Contains("pins: NULL given, 2 values needed"));
  const engram_task_option option = {"strict", 1};
  CHECK(to_choices(&option, 1)[0].name == "strict");
  CHECK(to_policy(ENGRAM_POLICY_SWEEP) == Policy::kSweep);
  CHECK_THROWS_WITH(to_policy(5), Contains("policy: 5 given, 0 to 4 allowed"));
  engram_options options = default_options();
  options.rules = ENGRAM_RULES_ORIGINAL;
  CHECK(to_make_options(options).rules == Rules::kOriginal);
  options.rules = -1;
  CHECK_THROWS_WITH(to_make_options(options), Contains("rules: -1 given"));
}

}  // namespace
}  // namespace engram::c
