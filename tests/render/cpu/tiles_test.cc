// Images of colours alone are drawn in tiles. Those that want depth, too, are drawn pixel by
// pixel: both must have the same colours.
#include <algorithm>
#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "core/batch/queries.h"
#include "core/batch/scripted_policy.h"
#include "core/image/image_batch.h"
#include "render/cpu/backdrop.h"
#include "render/make_renderer.h"
#include "tests/env_helpers.h"
#include "tests/render/still_life.h"

namespace engram::test {
namespace {

TEST_CASE("tiles have the colours of pixels drawn one by one", "[render]") {
  const std::vector<std::vector<int>> cameras = {{0}, {1}, {0, 1}, {1, 0, 1}};
  const bool antialias = GENERATE(false, true);
  for (const InstructionSet set : sets()) {
    for (unsigned seed = 0; seed < 6; ++seed) {
      const RenderRig rig = still_life(seed);
      std::vector<float> poses;
      const RenderInstances instances = two_cameras(rig, poses);
      for (const auto& [width, height] :
           {std::pair{1, 1}, {33, 70}, {128, 128}, {100, 75}, {256, 31}, {1100, 40}}) {
        const auto renderer = make_cpu_renderer(rig.scene, with(set, antialias), 1);
        for (const std::vector<int>& some : cameras) {
          INFO(name_of(set) << ", seed " << seed << ", " << width << " x " << height
                            << (antialias ? ", anti-aliased" : ""));
          CHECK(draw(*renderer, some, width, height, false, instances) ==
                draw(*renderer, some, width, height, true, instances));
        }
      }
    }
  }
}

TEST_CASE("tiles of the tasks' scenes have the colours of pixels drawn one by one", "[render]") {
  const std::string ids[] = {"RememberColor9-VLA-v0",          "ShellGameTouch-VLA-v0",
                             "BatteriesCheckerHard-15-VLA-v0", "TraceShapeEasy-VLA-v0",
                             "RotateLenientPos-VLA-v0",        "GatherAndRecall3-VLA-v0",
                             "InterceptGrabMedium-VLA-v0",     "BlinkCountButtonPressEasy-VLA-v0"};
  for (const std::string& id : ids) {
    const auto batch = make_running(id, {.num_envs = 2});
    SceneViews views(batch->physics_model(), 1);
    ImageSourceOptions image_options;
    image_options.for_people = false;
    ImageSource source(Queries(*batch).document(), views.body_names(), image_options, 1,
                       make_renderer);
    std::vector<int> cameras;
    for (const char* name : {"base_camera", "hand_camera", "render_camera"}) {
      cameras.push_back(find_camera(source, name));
    }
    std::vector<float> actions(static_cast<std::size_t>(2 * batch->action_dim()));
    for (int step = 0; step < 12; ++step) {
      ScriptedPolicy(*batch, Policy::kOracle).act(actions);
      batch->step(actions);
      const auto bodies = views.view(0, batch->state(), step % 2);
      const int width = step % 3 == 0 ? 128 : 40 + 7 * step;
      INFO(id << ", step " << step);
      const std::vector<int> pair = {cameras[0], cameras[1]};
      CHECK(draw(source, pair, width, 96, false, bodies) ==
            draw(source, pair, width, 96, true, bodies));
      CHECK(draw(source, cameras, width, 96, false, bodies) ==
            draw(source, cameras, width, 96, true, bodies));
    }
  }
}

TEST_CASE("old contents of working memory do not show in tiles", "[render]") {
  const std::vector<const cpu::Kernel*> kernels = [] {
    std::vector<const cpu::Kernel*> all = {cpu::baseline_kernel()};
    if (is_supported(InstructionSet::kAvx2)) all.push_back(cpu::avx2_kernel());
    if (is_supported(InstructionSet::kAvx512)) all.push_back(cpu::avx512_kernel());
    return all;
  }();
  for (const cpu::Kernel* kernel : kernels) {
    for (unsigned seed = 0; seed < 8; ++seed) {
      const RenderRig rig = still_life(seed);
      std::vector<float> poses;
      const RenderInstances instances = two_cameras(rig, poses);
      const cpu::PreparedScene prepared(rig.scene, {});
      cpu::FrameBuilder builder(prepared, kernel->setup, 100, 90);
      AlignedArray<float> w(cpu::kBlock * 128);
      AlignedArray<std::int32_t> code(w.size());
      std::vector<cpu::TileCandidate> candidates(rig.scene.geoms.size());
      cpu::TileRow row = {};
      row.pitch = 128;
      row.w = w.data();
      row.code = code.data();
      row.candidates = candidates.data();
      cpu::Backdrops backdrops(prepared, 112 * 90);
      // Colours with memory that holds `w_before` and `code_before` when a row of tiles begins.
      const auto colors = [&](int camera, float w_before, std::int32_t code_before) {
        const cpu::Backdrop* backdrop =
            backdrops.find(instances, camera, 100, 90, *kernel, builder, row);
        const cpu::FrameData& frame =
            builder.build(instances, camera, 100, 90,
                          backdrop != nullptr ? cpu::Shown::kMoving : cpu::Shown::kAll);
        std::vector<std::uint32_t> image;
        row.x = 0;
        row.tiles = 7;
        for (row.y = 0; row.y < 90; row.y += cpu::kBlock) {
          row.rows = std::min(cpu::kBlock, 90 - row.y);
          std::fill(w.begin(), w.end(), w_before);
          std::fill(code.begin(), code.end(), code_before);
          kernel->draw_tiles(frame, backdrop, row);
          for (int y = 0; y < row.rows; ++y) {
            for (int x = 0; x < 100; ++x) {
              const int tile = x / cpu::kBlock;
              image.push_back(row.source[tile][y * row.stride[tile] + x % cpu::kBlock]);
            }
          }
        }
        return image;
      };
      for (const int camera : {0, 1}) {
        const std::vector<std::uint32_t> expected = colors(camera, 0, 0);
        CHECK(colors(camera, 1e30F, -1) == expected);
        CHECK(colors(camera, 0, 0x00ffffff) == expected);
      }
    }
  }
}

}  // namespace
}  // namespace engram::test
