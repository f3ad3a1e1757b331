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

TEST_CASE("Bad environments, cameras and sizes are refused, and images before the first reset",
          "[scene_renderer]") {
  const auto batch = make(kId, {.num_envs = 1});
  SceneRenderer renderer(*batch);
  std::vector<std::uint8_t> rgb(3);
  CHECK_THROWS_WITH(renderer.render(0, "base_camera", 1, 1, rgb),
                    Contains("render before the first reset"));
  batch->reset();
  CHECK_THROWS_WITH(renderer.render(1, "base_camera", 1, 1, rgb), Contains("0 to 0"));
  CHECK_THROWS_WITH(renderer.render(0, "base_camera", 2, 1, rgb), Contains("6 needed"));
  CHECK_THROWS_WITH(renderer.render(0, "base_camera", 1, 5000, rgb), Contains("1 x 5000"));
  CHECK_THROWS_WITH(renderer.render(0, "nose", 1, 1, rgb), Contains("hand_camera"));
}

TEST_CASE("A batch without a renderer has no images", "[scene_renderer]") {
  const auto batch = test::make_running(kId);
  std::vector<std::uint8_t> rgb(3);
  CHECK_THROWS_WITH(SceneRenderer(*batch).render(0, "base_camera", 1, 1, rgb),
                    Contains("images without a renderer"));
}

TEST_CASE("A sensor's image on demand is the one that is observed", "[scene_renderer]") {
  BatchOptions options{.num_envs = 2, .obs_mode = ObsMode::kRgb};
  options.images.width = 24;
  options.images.height = 16;
  options.images.cameras = {"base_camera"};
  const auto batch = make(kId, options);
  batch->reset();
  SceneRenderer renderer(*batch);
  constexpr std::size_t kBytes = 24 * 16 * 3;
  std::vector<std::uint8_t> image(kBytes);
  for (int t = 0; t < 3; ++t) {
    for (int index = 0; index < 2; ++index) {
      renderer.render(index, "base_camera", 24, 16, image);
      const auto observed =
          batch->images().rgb.subspan(kBytes * static_cast<std::size_t>(index), kBytes);
      CHECK(std::ranges::equal(image, observed));
    }
    test::step(*batch, Policy::kOracle);
  }
}

TEST_CASE("Overlays are the task's, environment by environment", "[scene_renderer]") {
  const auto batch = make("BlinkCountButtonPressEasy-VLA-v0");
  batch->reset();
  Overlay overlay;
  CHECK_THROWS_WITH(SceneRenderer(*batch).overlay(1, overlay), Contains("0 to 0"));
  CHECK_NOTHROW(SceneRenderer(*batch).overlay(0, overlay));
}

}  // namespace
}  // namespace engram
