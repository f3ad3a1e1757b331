// One environment's own cameras, lights and surfaces against a scene that has them for all.
#include <catch2/catch.hpp>
#include <functional>
#include <vector>

#include "render/egl/egl_renderer.h"
#include "tests/render/has_egl.h"
#include "tests/render/render_fixture.h"

namespace engram::test {
namespace {

using MakeRenderer = std::function<std::unique_ptr<Renderer>(const RenderScene&)>;

// Geoms 0 and 1 are a grid and wood.
std::vector<RenderSurface> surfaces_of(const RenderScene& scene) {
  std::vector<RenderSurface> surfaces;
  for (const RenderGeom& geom : scene.geoms) surfaces.push_back({geom.pattern});
  return surfaces;
}

RenderLighting other_lights(const RenderScene& scene) {
  RenderLighting lighting;
  lighting.lights = scene.lights;
  lighting.lights[0].direction[0] = -0.7F;
  lighting.lights[0].direction[1] = 0.4F;
  lighting.lights[1].color[2] = 0.55F;
  lighting.ambient[0] = 0.35F;
  lighting.ambient[1] = 0.25F;
  lighting.ambient[2] = 0.45F;
  return lighting;
}

std::vector<std::uint8_t> draw(Renderer& renderer, const RenderInstances& rows) {
  constexpr int kSide = 96;
  std::vector<std::uint8_t> rgb(3 * kSide * kSide);
  RenderImage image;
  image.width = image.height = kSide;
  image.rgb = rgb.data();
  image.row_stride = 3 * kSide;
  renderer.render(0, rows, {&image, 1});
  return rgb;
}

// Draws the rig with changes, and a rig whose scene is like that.
void check(const MakeRenderer& make) {
  const RenderRig rig = crowd(3);
  const auto renderer = make(rig.scene);
  const std::vector<std::uint8_t> usual = draw(*renderer, rig.instances());

  SECTION("field of view") {
    const float fovy = 1.2F;
    RenderInstances rows = rig.instances();
    rows.camera_fovy = &fovy;
    RenderRig other = rig;
    other.scene.cameras[0].fovy = fovy;
    const auto rgb = draw(*renderer, rows);
    CHECK(rgb == draw(*make(other.scene), other.instances()));
    CHECK(rgb != usual);
  }
  SECTION("lights") {
    const RenderLighting lighting = other_lights(rig.scene);
    RenderInstances rows = rig.instances();
    rows.lighting = &lighting;
    RenderRig other = rig;
    other.scene.lights = lighting.lights;
    std::ranges::copy(lighting.ambient, other.scene.ambient);
    const auto rgb = draw(*renderer, rows);
    CHECK(rgb == draw(*make(other.scene), other.instances()));
    CHECK(rgb != usual);
  }
  SECTION("patterns") {
    std::vector<RenderSurface> surfaces = surfaces_of(rig.scene);
    surfaces[0].pattern = RenderPattern::kWood;
    surfaces[1].pattern = RenderPattern::kGrid;
    RenderInstances rows = rig.instances();
    rows.geom_surface = surfaces.data();
    RenderRig other = rig;
    other.scene.geoms[0].pattern = RenderPattern::kWood;
    other.scene.geoms[1].pattern = RenderPattern::kGrid;
    const auto rgb = draw(*renderer, rows);
    CHECK(rgb == draw(*make(other.scene), other.instances()));
    CHECK(rgb != usual);
  }
  SECTION("no pattern") {
    std::vector<RenderSurface> surfaces = surfaces_of(rig.scene);
    surfaces[1].pattern = RenderPattern::kPlain;
    RenderInstances rows = rig.instances();
    rows.geom_surface = surfaces.data();
    CHECK(draw(*renderer, rows) != usual);
  }
  SECTION("a turned and a finer pattern") {
    std::vector<RenderSurface> turned = surfaces_of(rig.scene);
    std::vector<RenderSurface> finer = turned;
    turned[1].turned = true;
    finer[1].scale = 4;
    RenderInstances rows = rig.instances();
    rows.geom_surface = turned.data();
    const auto first = draw(*renderer, rows);
    rows.geom_surface = finer.data();
    const auto second = draw(*renderer, rows);
    CHECK(first != usual);
    CHECK(second != usual);
    CHECK(first != second);
  }
  SECTION("none") {
    const std::vector<RenderSurface> surfaces = surfaces_of(rig.scene);
    RenderLighting lighting;
    lighting.lights = rig.scene.lights;
    std::ranges::copy(rig.scene.ambient, lighting.ambient);
    RenderInstances rows = rig.instances();
    rows.camera_fovy = &rig.scene.cameras[0].fovy;
    rows.lighting = &lighting;
    rows.geom_surface = surfaces.data();
    CHECK(draw(*renderer, rows) == usual);
  }
  // Images without changes are as before.
  CHECK(draw(*renderer, rig.instances()) == usual);
}

TEST_CASE("The ray caster draws an environment's own cameras, lights and surfaces", "[render]") {
  CpuRendererOptions options;
  options.shadow_rays = GENERATE(0, 3);
  check([&](const RenderScene& scene) { return make_cpu_renderer(scene, options, 1); });
}

TEST_CASE("OpenGL draws an environment's own cameras, lights and surfaces", "[render][egl]") {
  if (!has_egl()) return;
  EglRendererOptions options;
  options.shadows = GENERATE(false, true);
  check([&](const RenderScene& scene) { return make_egl_renderer(scene, options, 1); });
}

TEST_CASE("Both renderers draw the same surfaces", "[render][egl]") {
  if (!has_egl()) return;
  const RenderRig rig = crowd(5);
  std::vector<RenderSurface> surfaces = surfaces_of(rig.scene);
  surfaces[0] = {RenderPattern::kWood, true, 2};
  surfaces[1] = {RenderPattern::kGrid, false, 6};
  const RenderLighting lighting = other_lights(rig.scene);
  RenderInstances rows = rig.instances();
  rows.geom_surface = surfaces.data();
  rows.lighting = &lighting;
  const auto by_rays = draw(*make_cpu_renderer(rig.scene, {}, 1), rows);
  const auto by_gl = draw(*make_egl_renderer(rig.scene, {}, 1), rows);
  double difference = 0;
  for (std::size_t i = 0; i < by_rays.size(); ++i) difference += std::abs(by_rays[i] - by_gl[i]);
  CHECK(difference / static_cast<double>(by_rays.size()) < 2);
}

}  // namespace
}  // namespace engram::test
