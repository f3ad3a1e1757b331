// Boxes, capsules and cylinders projected in batches: the frame equals the one made one by one.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <limits>
#include <random>
#include <vector>

#include "render/cpu/frame_builder.h"
#include "tests/render/render_fixture.h"

namespace engram::test {
namespace {

using cpu::FrameData, cpu::PrimitiveKind, cpu::ScreenPrimitive, cpu::Surface, Eigen::Vector3f;

std::vector<const cpu::Kernel*> kernels() {
  std::vector<const cpu::Kernel*> all = {cpu::baseline_kernel()};
  if (is_supported(InstructionSet::kAvx2)) all.push_back(cpu::avx2_kernel());
  if (is_supported(InstructionSet::kAvx512)) all.push_back(cpu::avx512_kernel());
  return all;
}

// Many geoms of the three shapes, around the camera and far off, long and flat.
RenderRig scatter(unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> any(-1, 1);
  RenderRig rig;
  const auto length = [&] { return 0.002F * std::exp(3 + 3 * any(random)); };
  const RenderShape shapes[] = {RenderShape::kBox, RenderShape::kCapsule, RenderShape::kCylinder};
  for (std::size_t i = 0; i < 120; ++i) {
    const float spread = i % 4 == 0 ? 0.1F : 1;
    rig.add(shapes[i % 3], {length(), length(), length()},
            {spread * any(random), spread * any(random), spread * any(random)},
            turned(i % 7 == 0 ? 0 : 3 * any(random), {any(random), any(random), 1}),
            {any(random), 2 * any(random), 0.5F, 1});
    rig.emission.back() = 0.3F * any(random);
    rig.visible.back() = i % 11 == 0 ? 0 : 1;
  }
  // Some share middle and size with another: equally near.
  for (std::size_t i = 30; i < 48; ++i) {
    std::copy_n(rig.scene.geoms[i - 6].size, 3, rig.scene.geoms[i].size);
    std::copy_n(&rig.geom_pose[12 * (i - 6) + 9], 3, &rig.geom_pose[12 * i + 9]);
  }
  rig.geom_pose[12 * 5 + 9] = std::numeric_limits<float>::quiet_NaN();
  rig.geom_pose[12 * 7] = std::numeric_limits<float>::infinity();
  rig.add_light({1, 1, -1}, 0.4F);
  rig.add_light({0, 0, -1}, 0.3F);
  rig.add_light({any(random), any(random), any(random)}, 0.3F);
  rig.set_camera({0.1F * any(random), 0, 0}, turned(3 * any(random), {any(random), 1, 0}));
  return rig;
}

bool same_bits(const void* a, const void* b, std::size_t size) {
  return std::memcmp(a, b, size) == 0;
}

bool same_surface(const FrameData& a, const FrameData& b, int of_a, int of_b) {
  if (a.segments[of_a] != b.segments[of_b]) return false;
  const std::uint32_t code = a.codes[of_a];
  if ((code & cpu::kShaded) == 0) return b.codes[of_b] == code;
  if ((b.codes[of_b] & cpu::kShaded) == 0) return false;
  const Surface& one = a.surfaces[of_a];
  const Surface& other = b.surfaces[of_b];
  if (one.lighting != other.lighting || one.pattern != other.pattern) return false;
  const auto lights = static_cast<std::size_t>(a.light_count);
  return same_bits(one.constant, other.constant, sizeof one.constant) &&
         same_bits(one.light, other.light, 12 * lights) &&
         same_bits(one.toward, other.toward, sizeof one.toward[0] * lights);
}

bool same_primitive(const ScreenPrimitive& a, const ScreenPrimitive& b) {
  if (a.kind != b.kind || !same_bits(&a.rect, &b.rect, sizeof a.rect)) return false;
  if (a.surface_count != b.surface_count) return false;
  if (a.kind == PrimitiveKind::kCapsule) {
    return same_bits(a.conic, b.conic, sizeof a.conic) &&
           same_bits(a.local, b.local, sizeof a.local[0]) && a.offset[0] == b.offset[0] &&
           a.limit[0] == b.limit[0];
  }
  if (a.kind == PrimitiveKind::kCylinder && (!same_bits(a.conic, b.conic, sizeof a.conic[0]) ||
                                             a.camera_within_side != b.camera_within_side)) {
    return false;
  }
  const int planes = a.kind == PrimitiveKind::kCylinder ? 2 : 6;
  return a.front_count == b.front_count && a.back_count == b.back_count &&
         same_bits(a.planes, b.planes, sizeof(cpu::Affine) * static_cast<std::size_t>(planes));
}

TEST_CASE("geoms projected in batches give the same frame, bit for bit", "[render]") {
  for (const cpu::Kernel* kernel : kernels()) {
    std::size_t seen = 0;
    bool same = true;
    for (unsigned seed = 0; seed < 60; ++seed) {
      const RenderRig rig = scatter(seed);
      const cpu::PreparedScene prepared(rig.scene, {});
      cpu::FrameBuilder one_by_one(prepared, nullptr, 200, 200);
      cpu::FrameBuilder batched(prepared, kernel->setup, 200, 200);
      const int width = 33 + static_cast<int>(seed);
      const FrameData& expected = one_by_one.build(rig.instances(), 0, width, 80);
      const FrameData& frame = batched.build(rig.instances(), 0, width, 80);
      REQUIRE(frame.primitive_count == expected.primitive_count);
      for (int i = 0; i < frame.primitive_count; ++i) {
        const ScreenPrimitive& a = *frame.primitives[i];
        const ScreenPrimitive& b = *expected.primitives[i];
        same = same && same_primitive(a, b);
        for (int k = 0; same && k < a.surface_count; ++k) {
          same = same_surface(frame, expected, a.surface + k, b.surface + k);
        }
        ++seen;
      }
      const auto ranks = batched.ranks();
      for (std::size_t i = 0; i < ranks.size(); ++i) {
        same = same && ranks[i].depth == one_by_one.ranks()[i].depth &&
               ranks[i].geom == one_by_one.ranks()[i].geom;
      }
    }
    CHECK(same);
    CHECK(seen > 1000);
  }
}

}  // namespace
}  // namespace engram::test
