#include "core/batch/scene_renderer.h"

#include <catch2/catch.hpp>
#include <cstdint>
#include <vector>

#include "core/base/error.h"
#include "protocol/make/make.h"
#include "tests/env_helpers.h"

namespace engram {
namespace {

using Catch::Contains;

constexpr const char* kId = "RememberColor5-VLA-v0";

TEST_CASE("Bad environments, cameras and sizes are refused, and pictures before the first reset",
          "[scene_renderer]") {
  const auto env = make(kId, {.num_envs = 1});
  SceneRenderer renderer(*env);
  std::vector<std::uint8_t> rgb(3);
  CHECK_THROWS_WITH(renderer.render(0, "base_camera", 1, 1, rgb),
                    Contains("render before the first reset"));
  env->reset();
  CHECK_THROWS_WITH(renderer.render(1, "base_camera", 1, 1, rgb), Contains("0 to 0"));
  CHECK_THROWS_WITH(renderer.render(0, "base_camera", 2, 1, rgb), Contains("6 needed"));
  CHECK_THROWS_WITH(renderer.render(0, "base_camera", 1, 5000, rgb), Contains("1 x 5000"));
  CHECK_THROWS_WITH(renderer.render(0, "nose", 1, 1, rgb), Contains("hand_camera"));
}

TEST_CASE("A batch without a renderer has no pictures", "[scene_renderer]") {
  const auto env = test::make_env(kId);
  env->reset();
  std::vector<std::uint8_t> rgb(3);
  CHECK_THROWS_WITH(SceneRenderer(*env).render(0, "base_camera", 1, 1, rgb),
                    Contains("pictures without a renderer"));
}

TEST_CASE("A sensor's picture on demand is the one that is observed", "[scene_renderer]") {
  BatchOptions options;
  options.num_envs = 2;
  options.obs_mode = ObsMode::kRgb;
  options.images.width = 24;
  options.images.height = 16;
  options.images.cameras = {"base_camera"};
  const auto env = make(kId, options);
  env->reset();
  SceneRenderer renderer(*env);
  constexpr std::size_t kBytes = 24 * 16 * 3;
  std::vector<std::uint8_t> picture(kBytes);
  for (int t = 0; t < 3; ++t) {
    for (int index = 0; index < 2; ++index) {
      renderer.render(index, "base_camera", 24, 16, picture);
      const auto observed =
          env->images().rgb.subspan(kBytes * static_cast<std::size_t>(index), kBytes);
      CHECK(std::ranges::equal(picture, observed));
    }
    test::step(*env, Policy::kOracle);
  }
}

TEST_CASE("Overlays are the task's, environment by environment", "[scene_renderer]") {
  const auto env = make("BlinkCountButtonPressEasy-VLA-v0");
  env->reset();
  Overlay overlay;
  CHECK_THROWS_WITH(SceneRenderer(*env).overlay(1, overlay), Contains("0 to 0"));
  CHECK_NOTHROW(SceneRenderer(*env).overlay(0, overlay));
}

}  // namespace
}  // namespace engram
