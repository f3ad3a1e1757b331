#include "apps/record_view.h"

#include <catch2/catch.hpp>
#include <cstring>

#include "core/batch/scene_renderer.h"

namespace engram::apps {
namespace {

std::unique_ptr<Batch> scene() {
  MakeOptions options;
  options.num_envs = 1;
  options.threads = 1;
  auto batch = make("RememberColor3-VLA-v0", options);
  batch->reset();
  return batch;
}

TEST_CASE("A view of one camera is the camera's image", "[apps]") {
  const auto batch = scene();
  RecordView view(*batch, {.camera = "base", .width = 24, .height = 16});
  std::vector<std::uint8_t> rgb(24 * 16 * 3);
  SceneRenderer(*batch).render(0, "base_camera", 24, 16, rgb);
  CHECK(view.draw() == rgb);
}

TEST_CASE("A view of all cameras has the human view on its left", "[apps]") {
  const auto batch = scene();
  RecordView view(*batch, {.camera = "all", .width = 96, .height = 64});
  const std::vector<std::uint8_t> all = view.draw();
  REQUIRE(all.size() == 96 * 64 * 3);
  std::vector<std::uint8_t> human(64 * 64 * 3);
  SceneRenderer(*batch).render(0, "render_camera", 64, 64, human);
  bool same = true;
  for (std::size_t y = 0; y < 64; ++y) {
    same = same && std::memcmp(&all[y * 96 * 3], &human[y * 64 * 3], 64 * 3) == 0;
  }
  CHECK(same);
}

TEST_CASE("Overlays change the human view", "[apps]") {
  const auto batch = scene();
  ViewOptions options{.camera = "render", .width = 128, .height = 128};
  const std::vector<std::uint8_t> plain = RecordView(*batch, options).draw();
  options.overlays = true;
  CHECK(RecordView(*batch, options).draw() != plain);
}

}  // namespace
}  // namespace engram::apps
