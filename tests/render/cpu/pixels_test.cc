// Which bytes are written, and that they are always the same ones.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdlib>
#include <thread>

#include "tests/allocation_counter.h"
#include "tests/render/render_fixture.h"

namespace engram::test {
namespace {

TEST_CASE("images of any size and layout have the same pixels", "[render]") {
  const RenderRig rig = crowd(1);
  const auto renderer = make_cpu_renderer(rig.scene, {}, 1);
  for (const auto& [width, height] : {std::pair{1, 1}, {3, 2}, {17, 9}, {64, 64}, {129, 131}}) {
    const Image drawn = rig.render(*renderer, width, height);
    // Two cameras in one buffer, six bytes a pixel, and a margin that must stay as it is.
    const std::ptrdiff_t row = 6 * width + 5;
    std::vector<std::uint8_t> buffer(static_cast<std::size_t>(row * height), 77);
    RenderImage image;
    image.width = width;
    image.height = height;
    image.pixel_stride = 6;
    image.row_stride = row;
    image.rgb = buffer.data() + 3;
    renderer->render(0, rig.instances(), {&image, 1});
    bool same = true;
    for (int y = 0; y < height; ++y) {
      for (int b = 0; b < row; ++b) {
        const int byte = buffer[static_cast<std::size_t>(y * row + b)];
        const bool inside = b < 6 * width && b % 6 >= 3;
        same =
            same && byte == (inside ? drawn.color(b / 6, y)[static_cast<std::size_t>(b % 3)] : 77);
      }
    }
    CHECK(same);
  }
}

TEST_CASE("any of the outputs may be left out", "[render]") {
  const RenderRig rig = crowd(2);
  const auto renderer = make_cpu_renderer(rig.scene, {}, 1);
  const Image all = rig.render(*renderer);
  std::vector<float> depth(64 * 64);
  RenderImage image;
  image.width = image.height = 64;
  image.depth = depth.data();
  renderer->render(0, rig.instances(), {&image, 1});
  CHECK(depth == all.depth);
}

TEST_CASE("images beyond the limits stay untouched", "[render]") {
  const RenderRig rig = crowd(2);
  const CpuRendererOptions options{.max_width = 20, .max_height = 10};
  const auto renderer = make_cpu_renderer(rig.scene, options, 1);
  std::vector<std::uint8_t> bytes(3 * 21 * 11, 9);
  RenderImage image;
  image.rgb = bytes.data();
  image.row_stride = 60;
  for (const auto& [camera, width, height] :
       {std::tuple{0, 21, 10}, {0, 20, 11}, {0, 0, 5}, {1, 5, 5}, {-1, 5, 5}}) {
    image.camera = camera;
    image.width = width;
    image.height = height;
    renderer->render(0, rig.instances(), {&image, 1});
  }
  CHECK(bytes == std::vector<std::uint8_t>(bytes.size(), 9));
}

TEST_CASE("all instruction sets paint alike", "[render]") {
  CpuRendererOptions options;
  options.shadow_rays = GENERATE(0, 3);
  options.antialias = GENERATE(false, true);
  for (const InstructionSet set : {InstructionSet::kAvx2, InstructionSet::kAvx512}) {
    if (!is_supported(set)) continue;
    std::size_t differing = 0;
    std::size_t bytes = 0;
    for (unsigned seed = 0; seed < 8; ++seed) {
      const RenderRig rig = crowd(seed);
      options.instruction_set = InstructionSet::kBaseline;
      const Image expected = rig.render(100, 75, options);
      options.instruction_set = set;
      const Image image = rig.render(100, 75, options);
      for (std::size_t i = 0; i < image.rgb.size(); ++i) {
        const int difference = std::abs(image.rgb[i] - expected.rgb[i]);
        CHECK(difference <= 1);
        differing += difference != 0 ? 1 : 0;
      }
      bytes += image.rgb.size();
      CHECK(image.segment == expected.segment);
    }
    INFO(name_of(set));
    CHECK(differing <= bytes / 10000);
  }
  CHECK(is_supported(InstructionSet::kAuto));
  CHECK(is_supported(InstructionSet::kBaseline));
}

TEST_CASE("images do not depend on workers, threads or what was drawn before", "[render]") {
  const RenderRig first = crowd(3);
  const RenderRig second = crowd(4);
  const auto renderer = make_cpu_renderer(first.scene, {}, 3);
  const Image expected = first.render(*renderer);
  (void)second.render(*renderer, 33, 70);
  CHECK(first.render(*renderer).rgb == expected.rgb);

  std::vector<std::vector<std::uint8_t>> images(3, std::vector<std::uint8_t>(3 * 64 * 64));
  std::vector<std::thread> threads;
  for (int worker = 0; worker < 3; ++worker) {
    threads.emplace_back([&, worker] {
      RenderImage image;
      image.width = image.height = 64;
      image.row_stride = 192;
      image.rgb = images[static_cast<std::size_t>(worker)].data();
      for (int i = 0; i < 20; ++i) {
        renderer->render(worker, (i % 2 == 0 ? second : first).instances(), {&image, 1});
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  for (const auto& image : images) CHECK(image == expected.rgb);
}

TEST_CASE("rendering does not allocate", "[render]") {
  const CpuRendererOptions options{.shadow_rays = 2, .antialias = true};
  const RenderRig rig = crowd(5);
  const auto renderer = make_cpu_renderer(rig.scene, options, 1);
  std::vector<std::uint8_t> bytes(3 * 96 * 96);
  RenderImage image;
  image.width = image.height = 96;
  image.row_stride = 288;
  image.rgb = bytes.data();
  const RenderInstances instances = rig.instances();
  const std::int64_t before = allocation_count();
  renderer->render(0, instances, {&image, 1});
  CHECK(allocation_count() == before);
}

}  // namespace
}  // namespace engram::test
