#include <algorithm>
#include <catch2/catch.hpp>

#include "core/batch/scene_renderer.h"
#include "core/batch/snapshot.h"
#include "protocol/make/make.h"
#include "tests/env_helpers.h"

namespace {

using namespace engram;

constexpr const char* kId = "RememberColor9-VLA-v0";
constexpr std::size_t kBytes = 128 * 128 * 6;

BatchOptions rgb_options(int num_envs, std::uint64_t seed = 11) {
  BatchOptions options{.num_envs = num_envs, .seed = seed, .threads = 1, .obs_mode = ObsMode::kRgb};
  return options;
}

using Image = std::vector<std::uint8_t>;

Image image_of(const Batch& batch, int index) {
  const auto rgb = batch.images().rgb.subspan(kBytes * static_cast<std::size_t>(index), kBytes);
  return {rgb.begin(), rgb.end()};
}

Image all_images(const Batch& batch) {
  return {batch.images().rgb.begin(), batch.images().rgb.end()};
}

Image image(Batch& batch, int index, const char* camera) {
  Image rgb(128 * 128 * 3);
  SceneRenderer(batch).render(index, camera, 128, 128, rgb);
  return rgb;
}

// The images of every step of a run with the oracle.
Image run(const BatchOptions& options, int steps) {
  const auto batch = make(kId, options);
  batch->reset();
  Image images = all_images(*batch);
  for (int i = 0; i < steps; ++i) {
    test::step(*batch, Policy::kOracle);
    images.insert(images.end(), batch->images().rgb.begin(), batch->images().rgb.end());
  }
  return images;
}

}  // namespace

TEST_CASE("Image observations are base camera then wrist camera, beside proprio alone",
          "[render]") {
  const auto batch = make(kId, rgb_options(2));
  batch->reset();
  REQUIRE(batch->images().rgb.size() == 2 * kBytes);
  CHECK(batch->outputs().observation.empty());
  CHECK(batch->outputs().proprio[6] == Approx(0.08));
  for (int index = 0; index < 2; ++index) {
    const Image both = image_of(*batch, index);
    const Image base = image(*batch, index, "base_camera");
    const Image hand = image(*batch, index, "hand_camera");
    bool same = true;
    for (std::size_t pixel = 0; pixel < 128 * 128; ++pixel) {
      same &= std::equal(&both[6 * pixel], &both[6 * pixel] + 3, &base[3 * pixel]);
      same &= std::equal(&both[6 * pixel] + 3, &both[6 * pixel] + 6, &hand[3 * pixel]);
    }
    CHECK(same);
  }
}

TEST_CASE("State observations have no images", "[render]") {
  const auto batch = make(kId, {.num_envs = 1});
  batch->reset();
  CHECK(batch->images().rgb.empty());
  CHECK(test::final_images(*batch).rgb.empty());
}

TEST_CASE("Images are the same bytes for any threads, chunks, batch size and slot", "[render]") {
  const Image expected = run(rgb_options(5), 12);
  BatchOptions other = rgb_options(5);
  other.threads = 3;
  other.chunk = 2;
  CHECK(run(other, 12) == expected);

  const auto batch = make(kId, rgb_options(5));
  const auto single = make(kId, rgb_options(1, 11 + 3));
  batch->reset();
  single->reset();
  for (int i = 0; i < 12; ++i) {
    CHECK(image_of(*batch, 3) == image_of(*single, 0));
    test::step(*batch, Policy::kOracle);
    test::step(*single, Policy::kOracle);
  }
}

TEST_CASE("A partial reset redraws only what it resets", "[render]") {
  const auto batch = make(kId, rgb_options(3));
  batch->reset();
  for (int i = 0; i < 12; ++i) test::step(*batch, Policy::kOracle);
  const Image first = image_of(*batch, 0);
  const Image second = image_of(*batch, 1);
  const std::uint8_t mask[3] = {0, 1, 0};
  batch->reset({.mask = mask, .seeds = {}, .pins = nullptr});
  CHECK(image_of(*batch, 0) == first);
  CHECK(image_of(*batch, 1) != second);
}

TEST_CASE("The last image of an episode is kept when its reset is in the same step", "[render]") {
  BatchOptions same = rgb_options(1);
  same.auto_reset = AutoReset::kSameStep;
  BatchOptions off = rgb_options(1);
  off.auto_reset = AutoReset::kOff;
  const auto batch = make(kId, same);
  const auto twin = make(kId, off);
  batch->reset();
  twin->reset();
  for (int i = 0; i < batch->info().horizon; ++i) {
    test::step(*batch, Policy::kOracle);
    test::step(*twin, Policy::kOracle);
  }
  REQUIRE(batch->outputs().final_mask[0] == 1);
  CHECK(std::equal(test::final_images(*batch).rgb.begin(), test::final_images(*batch).rgb.end(),
                   twin->images().rgb.begin()));
  CHECK(image_of(*batch, 0) != image_of(*twin, 0));
}

TEST_CASE("Next-step resets show the last image, then the first", "[render]") {
  BatchOptions options = rgb_options(1);
  options.auto_reset = AutoReset::kNextStep;
  const auto batch = make(kId, options);
  batch->reset();
  for (int i = 0; i < batch->info().horizon; ++i) test::step(*batch, Policy::kOracle);
  const Image last = image_of(*batch, 0);
  test::step(*batch, Policy::kOracle);
  const Image first = image_of(*batch, 0);
  CHECK(first != last);

  const auto fresh = make(kId, rgb_options(1));
  fresh->reset();
  fresh->reset();  // the second episode of that seed
  CHECK(first == image_of(*fresh, 0));
}

TEST_CASE("Restoring a snapshot restores the image", "[render]") {
  const auto batch = make(kId, rgb_options(2));
  batch->reset();
  for (int i = 0; i < 9; ++i) test::step(*batch, Policy::kOracle);
  const std::vector<std::byte> snapshot = Snapshotter(*batch).save(0);
  const Image then = image_of(*batch, 0);
  for (int i = 0; i < 5; ++i) test::step(*batch, Policy::kOracle);
  REQUIRE(image_of(*batch, 0) != then);
  Snapshotter(*batch).restore(1, snapshot);
  CHECK(image_of(*batch, 1) == then);
}

TEST_CASE("Other sizes and cameras can be had", "[render]") {
  BatchOptions options = rgb_options(1);
  options.images.width = 33;
  options.images.height = 20;
  options.images.cameras = {"render_camera", "base_camera", "hand_camera"};
  const auto batch = make(kId, options);
  batch->reset();
  CHECK(batch->images().rgb.size() == 33 * 20 * 9);
  CHECK(std::any_of(batch->images().rgb.begin(), batch->images().rgb.end(),
                    [](std::uint8_t b) { return b > 0; }));
}

TEST_CASE("Bad sizes, cameras and renderers are refused by name", "[render]") {
  using Catch::Contains;
  BatchOptions size = rgb_options(1);
  size.images.width = 0;
  CHECK_THROWS_WITH(make(kId, size), Contains("0 x 128") && Contains("4096"));
  BatchOptions camera = rgb_options(1);
  camera.images.cameras = {"side_camera"};
  CHECK_THROWS_WITH(make(kId, camera), Contains("side_camera") && Contains("base_camera"));
  BatchOptions renderer = rgb_options(1);
  renderer.image_options.renderer = "vulkan";
  CHECK_THROWS_WITH(make(kId, renderer), Contains("vulkan") && Contains("cpu"));
}
