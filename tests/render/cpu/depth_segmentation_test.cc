// Depth and segments as observations have them, drawn in tiles. Images that want them as plain
// numbers, too, are drawn pixel by pixel: both must have the same.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "tests/render/still_life.h"

namespace engram::test {
namespace {

struct Kinds {
  bool colors, depth, segments;
};

// Images of some cameras, whose pixels lie side by side.
struct Drawn {
  std::vector<std::uint8_t> rgb;
  std::vector<std::int16_t> depth;
  std::vector<std::int16_t> segments;

  bool operator==(const Drawn&) const = default;
};

// Plain numbers of one camera.
struct Plain {
  std::vector<float> depth;
  std::vector<std::int32_t> segments;
};

constexpr std::int16_t kUntouched = 4321;

Drawn draw(Renderer& renderer, const RenderInstances& instances, const std::vector<int>& cameras,
           int width, int height, const Kinds& kinds, std::vector<Plain>* plain) {
  const std::size_t pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  const std::size_t cells = pixels * cameras.size();
  Drawn drawn = {std::vector<std::uint8_t>(3 * cells, 77),
                 std::vector<std::int16_t>(cells + 1, kUntouched),
                 std::vector<std::int16_t>(cells + 1, kUntouched)};
  std::vector<RenderImage> images;
  if (plain != nullptr) plain->assign(cameras.size(), {});
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    RenderImage image;
    image.camera = cameras[i];
    image.width = width;
    image.height = height;
    image.pixel_stride = static_cast<std::ptrdiff_t>(3 * cameras.size());
    image.row_stride = image.pixel_stride * width;
    image.cell_step = static_cast<std::ptrdiff_t>(cameras.size());
    image.cell_row = image.cell_step * width;
    if (kinds.colors) image.rgb = drawn.rgb.data() + 3 * i;
    if (kinds.depth) image.depth_mm = drawn.depth.data() + i;
    if (kinds.segments) image.segment_id = drawn.segments.data() + i;
    if (plain != nullptr) {
      (*plain)[i] = {std::vector<float>(pixels), std::vector<std::int32_t>(pixels)};
      image.depth = (*plain)[i].depth.data();
      image.segment = (*plain)[i].segments.data();
    }
    images.push_back(image);
  }
  renderer.render(0, instances, images);
  return drawn;
}

constexpr Kinds kSome[] = {{true, true, false}, {true, false, true},  {true, true, true},
                           {false, true, true}, {false, true, false}, {false, false, true}};

TEST_CASE("tiles have the depth and segments of pixels drawn one by one", "[render][depth]") {
  const std::vector<std::vector<int>> cameras = {{0}, {1}, {0, 1}, {1, 0, 1}};
  const bool antialias = GENERATE(false, true);
  for (const InstructionSet set : sets()) {
    for (unsigned seed = 0; seed < 4; ++seed) {
      const RenderRig rig = still_life(seed);
      std::vector<float> poses;
      const RenderInstances instances = two_cameras(rig, poses);
      for (const auto& [width, height] :
           {std::pair{1, 1}, {33, 70}, {128, 128}, {256, 31}, {1100, 40}}) {
        const auto renderer = make_cpu_renderer(rig.scene, with(set, antialias), 1);
        for (const std::vector<int>& some : cameras) {
          for (const Kinds& kinds : kSome) {
            INFO(name_of(set) << ", seed " << seed << ", " << width << " x " << height
                              << (antialias ? ", anti-aliased" : "") << kinds.colors << kinds.depth
                              << kinds.segments);
            std::vector<Plain> plain;
            const Drawn tiles = draw(*renderer, instances, some, width, height, kinds, nullptr);
            CHECK(tiles == draw(*renderer, instances, some, width, height, kinds, &plain));
            CHECK(tiles.depth.back() == kUntouched);
            CHECK(tiles.segments.back() == kUntouched);
          }
        }
      }
    }
  }
}

TEST_CASE("depth and segments as observations have them are the plain ones, rounded",
          "[render][depth]") {
  const RenderRig rig = still_life(2);
  std::vector<float> poses;
  const RenderInstances instances = two_cameras(rig, poses);
  const auto renderer = make_cpu_renderer(rig.scene, {}, 1);
  std::vector<Plain> plain;
  const Drawn drawn = draw(*renderer, instances, {0, 1}, 128, 96, {true, true, true}, &plain);
  float worst = 0;
  int nothing = 0;
  for (std::size_t i = 0; i < 128 * 96 * 2; ++i) {
    const Plain& camera = plain[i % 2];
    REQUIRE(drawn.segments[i] == camera.segments[i / 2]);
    const float exact = std::min(1000 * camera.depth[i / 2], 32767.0F);
    worst = std::max(worst, std::abs(exact - static_cast<float>(drawn.depth[i])));
    nothing += camera.segments[i / 2] == 0 ? 1 : 0;
    CHECK((drawn.depth[i] == 0) == (camera.segments[i / 2] == 0));
  }
  CHECK(worst <= 0.501F);
  CHECK(nothing > 0);
}

TEST_CASE("depth ends at 32767 mm, and is 0 where nothing is", "[render][depth]") {
  RenderRig rig;
  rig.add(RenderShape::kBox, {1, 1, 1}, {40, 0, 0});
  rig.scene.geoms.back().still = GENERATE(false, true);
  rig.scene.cameras[0].still = true;
  const auto renderer = make_cpu_renderer(rig.scene, {}, 1);
  const Drawn drawn = draw(*renderer, rig.instances(), {0}, 65, 65, {true, true, true}, nullptr);
  CHECK(drawn.depth[65 * 32 + 32] == 32767);
  CHECK(drawn.segments[65 * 32 + 32] == 1);
  CHECK(drawn.depth[0] == 0);
  CHECK(drawn.segments[0] == 0);
}

TEST_CASE("geoms that move leave no trace in kept depth and segments", "[render][depth]") {
  RenderRig rig = still_life(3);
  std::vector<float> poses;
  const RenderInstances instances = two_cameras(rig, poses);
  const auto renderer = make_cpu_renderer(rig.scene, {}, 1);
  const Kinds all = {true, true, true};
  (void)draw(*renderer, instances, {0, 1}, 128, 128, all, nullptr);
  for (std::size_t i = 0; i < rig.scene.geoms.size(); ++i) {
    if (!rig.scene.geoms[i].still) rig.visible[i] = 0;
  }
  std::vector<Plain> plain;
  const auto fresh = make_cpu_renderer(rig.scene, {}, 1);
  CHECK(draw(*renderer, instances, {0, 1}, 128, 128, all, nullptr) ==
        draw(*fresh, instances, {0, 1}, 128, 128, all, &plain));
}

}  // namespace
}  // namespace engram::test
