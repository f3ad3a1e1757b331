// Images of what never moves, kept by the ray caster, are not seen in its results.
#include "render/cpu/backdrop.h"

#include <catch2/catch.hpp>
#include <thread>
#include <vector>

#include "tests/render/still_life.h"

namespace engram::test {
namespace {

TEST_CASE("geoms that move or are hidden leave no trace in a backdrop", "[render]") {
  RenderRig rig = still_life(3);
  std::vector<float> poses;
  const RenderInstances instances = two_cameras(rig, poses);
  const auto renderer = make_cpu_renderer(rig.scene, with(InstructionSet::kAuto), 1);
  (void)draw(*renderer, {0, 1}, 128, 128, false, instances);  // keeps floor, table and the like
  for (std::size_t i = 0; i < rig.scene.geoms.size(); ++i) {
    if (!rig.scene.geoms[i].still) rig.visible[i] = 0;
  }
  const auto fresh = make_cpu_renderer(rig.scene, with(InstructionSet::kAuto), 1);
  CHECK(draw(*renderer, {0, 1}, 128, 128, false, instances) ==
        draw(*fresh, {0, 1}, 128, 128, true, instances));
}

TEST_CASE("a geom that is drawn before the backdrop wins where both are equally near", "[render]") {
  // Two boxes with one front; the one that moves is the larger, so it comes first.
  RenderRig rig;
  rig.add(RenderShape::kBox, {0.5F, 0.5F, 0.5F}, {2.5F, 0, 0}, Eigen::Matrix3f::Identity(),
          {1, 0, 0, 1});
  rig.scene.geoms[0].still = true;
  rig.add(RenderShape::kBox, {1, 1, 1}, {3, 0, 0}, Eigen::Matrix3f::Identity(), {0, 1, 0, 1});
  rig.scene.cameras[0].still = true;
  const auto renderer = make_cpu_renderer(rig.scene, {}, 1);
  const Rgb tiles = draw(*renderer, {0}, 64, 64, false, rig.instances());
  CHECK(tiles == draw(*renderer, {0}, 64, 64, true, rig.instances()));
  CHECK(tiles[3 * (32 * 64 + 32)] == 0);
}

TEST_CASE("workers that ask for the first image at once all get it", "[render]") {
  const RenderRig rig = still_life(4);
  std::vector<float> poses;
  const RenderInstances instances = two_cameras(rig, poses);
  const Rgb expected = draw(*make_cpu_renderer(rig.scene, {}, 1), {0}, 64, 64, true, instances);
  for (int round = 0; round < 20; ++round) {
    const auto renderer = make_cpu_renderer(rig.scene, {}, 4);
    std::vector<Rgb> images(4, Rgb(expected.size()));
    std::vector<std::thread> threads;
    threads.reserve(4);
    for (int worker = 0; worker < 4; ++worker) {
      threads.emplace_back([&, worker] {
        RenderImage image;
        image.width = image.height = 64;
        image.row_stride = 192;
        image.rgb = images[static_cast<std::size_t>(worker)].data();
        for (int i = 0; i < 3; ++i) renderer->render(worker, instances, {&image, 1});
      });
    }
    for (std::thread& thread : threads) thread.join();
    for (const Rgb& image : images) CHECK(image == expected);
  }
}

}  // namespace
}  // namespace engram::test
