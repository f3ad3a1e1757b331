#include "render/cpu/cpu_renderer.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "core/base/error.h"
#include "tests/render/render_fixture.h"

namespace engram::test {
namespace {

using Eigen::Matrix3f, Eigen::Vector3f;
using Color = std::array<int, 3>;

TEST_CASE("spheres are shaded by Lambert's law", "[render]") {
  RenderRig rig;
  rig.add(RenderShape::kSphere, {1, 0, 0}, {4, 0, 0}, Matrix3f::Identity(), {0.2F, 0.4F, 0.8F, 1});
  rig.add_light({1, 0, 0}, 0.5F);
  rig.add_light({0, 0, -2}, 0.25F);
  constexpr int kSize = 257;
  const Image image = rig.render(kSize, kSize);

  for (int y = 0; y < kSize; y += 4) {
    for (int x = 0; x < kSize; x += 4) {
      if (image.segment[image.at(x, y)] == 0) continue;
      const float depth = image.depth[image.at(x, y)];
      const Vector3f point(depth, -((static_cast<float>(x) + 0.5F) / kSize * 2 - 1) * depth,
                           (1 - (static_cast<float>(y) + 0.5F) / kSize * 2) * depth);
      const Vector3f normal = point - Vector3f(4, 0, 0);
      REQUIRE(normal.norm() == Approx(1).margin(1e-3));
      const float light =
          0.5F + 0.5F * std::max(-normal.x(), 0.0F) + 0.25F * std::max(normal.z(), 0.0F);
      const Color color = image.color(x, y);
      CHECK(color[0] == Approx(255 * 0.2F * light).margin(1.1));
      CHECK(color[1] == Approx(255 * 0.4F * light).margin(1.1));
      CHECK(color[2] == Approx(std::min(255 * 0.8F * light, 255.0F)).margin(1.1));
    }
  }
  // The silhouette: tangent cone of half angle asin(1/4).
  int width = 0;
  for (int x = 0; x < kSize; ++x) width += image.segment[image.at(x, kSize / 2)];
  CHECK(width == Approx(kSize / std::sqrt(15.0)).margin(1.01));
}

TEST_CASE("faces and round sides have the light of their normals", "[render]") {
  RenderRig rig;
  rig.scene.ambient[0] = rig.scene.ambient[1] = rig.scene.ambient[2] = 0.2F;
  rig.add_light({1, 0, 0}, 0.6F);
  SECTION("box") { rig.add(RenderShape::kBox, {1, 1, 1}, {4, 0, 0}); }
  SECTION("cylinder from the side") { rig.add(RenderShape::kCylinder, {1, 1, 0}, {4, 0, 0}); }
  SECTION("capsule from the side") { rig.add(RenderShape::kCapsule, {1, 1, 0}, {4, 0, 0}); }
  SECTION("cap of a cylinder") {
    rig.add(RenderShape::kCylinder, {1, 1, 0}, {4, 0, 0}, turned(1.5707963F, {0, 1, 0}));
  }
  SECTION("end of a capsule") {
    rig.add(RenderShape::kCapsule, {1, 1, 0}, {4, 0, 0}, turned(1.5707963F, {0, 1, 0}));
  }
  SECTION("ellipsoid") { rig.add(RenderShape::kEllipsoid, {1, 2, 0.5F}, {4, 0, 0}); }
  SECTION("plane") {
    rig.add(RenderShape::kPlane, {1, 1, 0}, {4, 0, 0}, turned(-1.5707963F, {0, 1, 0}));
  }
  const Image image = rig.render(65, 65);
  CHECK(image.color(32, 32) == Color{204, 204, 204});
  CHECK(image.color(0, 0) == Color{0, 0, 0});
}

TEST_CASE("a mesh looks like the box it is", "[render]") {
  RenderRig box;
  RenderRig mesh;
  for (RenderRig* rig : {&box, &mesh}) {
    rig->add_light({1, 0.5F, -1}, 0.7F);
    rig->add(rig == &box ? RenderShape::kBox : RenderShape::kMesh, {0.5F, 0.3F, 0.4F}, {2, 0.1F, 0},
             turned(0.7F, {1, 2, 3}), {1, 0.5F, 0.2F, 1});
  }
  mesh.scene.meshes.push_back(box_mesh(0.5F, 0.3F, 0.4F));
  mesh.scene.geoms[0].mesh = 0;
  CHECK(box.render().rgb == mesh.render().rgb);
  CHECK(box.render().segment == mesh.render().segment);
}

TEST_CASE("a camera inside a geom looks out of it", "[render]") {
  RenderRig rig;
  const int wall = rig.add(RenderShape::kBox, {0.1F, 5, 5}, {3, 0, 0});
  for (const RenderShape shape :
       {RenderShape::kSphere, RenderShape::kCapsule, RenderShape::kEllipsoid,
        RenderShape::kCylinder, RenderShape::kBox}) {
    rig.add(shape, {0.5F, 0.5F, 0.5F}, {0.1F, 0, 0}, turned(0.3F, {1, 1, 0}));
  }
  CHECK(rig.render().segment == std::vector<std::int32_t>(64 * 64, wall));
}

TEST_CASE("the near plane cuts", "[render]") {
  RenderRig rig;
  rig.scene.cameras[0].near_clip = 0.1F;
  const int wall = rig.add(RenderShape::kBox, {0.1F, 50, 50}, {10, 0, 0});
  rig.add(RenderShape::kBox, {0.01F, 0.1F, 0.1F}, {0.1F, 0, 0});  // its front is nearer than 0.1
  CHECK(rig.render().segment[32 * 64 + 32] == wall);
  const int finger = rig.add(RenderShape::kBox, {0.01F, 0.1F, 0.1F}, {0.12F, 0, 0});
  CHECK(rig.render().segment[32 * 64 + 32] == finger);
}

TEST_CASE("hidden geoms and transparent ones are not drawn", "[render]") {
  RenderRig rig;
  rig.add(RenderShape::kSphere, {1, 0, 0}, {4, 0, 0});
  const auto renderer = make_cpu_renderer(rig.scene, {}, 1);
  const std::vector<std::int32_t> nothing(64 * 64, 0);
  CHECK(rig.render(*renderer).segment != nothing);
  rig.visible[0] = 0;
  CHECK(rig.render(*renderer).segment == nothing);
  rig.visible[0] = 1;
  rig.rgba[3] = 0;
  CHECK(rig.render(*renderer).segment == nothing);
  rig.rgba[3] = 0.1F;
  CHECK(rig.render(*renderer).color(32, 32) == Color{128, 128, 128});
}

TEST_CASE("geoms with broken poses are not drawn", "[render]") {
  for (const float value : {std::numeric_limits<float>::quiet_NaN(),
                            std::numeric_limits<float>::infinity(), 1e30F, -1e30F, 0.0F}) {
    for (const RenderShape shape :
         {RenderShape::kPlane, RenderShape::kSphere, RenderShape::kCapsule, RenderShape::kEllipsoid,
          RenderShape::kCylinder, RenderShape::kBox}) {
      RenderRig rig;
      rig.add(shape, {1, 1, 1}, {4, 0, 0});
      const auto renderer = make_cpu_renderer(rig.scene, {}, 1);
      for (std::size_t i = 0; i < 12; ++i) {
        RenderRig broken = rig;
        broken.geom_pose[i] = value;
        (void)broken.render(*renderer);
        broken = rig;
        broken.camera_pose[i] = value;
        const Image image = broken.render(*renderer);
        if (!std::isfinite(value)) CHECK(image.segment == std::vector<std::int32_t>(64 * 64, 0));
      }
    }
  }
}

TEST_CASE("what emits light is brighter by its own colour", "[render]") {
  RenderRig rig;
  rig.add(RenderShape::kBox, {1, 1, 1}, {4, 0, 0}, Matrix3f::Identity(), {0.4F, 0.3F, 0, 1});
  CHECK(rig.render().color(32, 32) == Color{51, 38, 0});
  rig.emission[0] = 1;
  CHECK(rig.render().color(32, 32) == Color{153, 115, 0});
  rig.emission[0] = 10;
  CHECK(rig.render().color(32, 32) == Color{255, 255, 0});
}

TEST_CASE("the background has its colour", "[render]") {
  RenderRig rig;
  rig.scene.background[1] = 0.5F;
  const Image image = rig.render(17, 5);
  CHECK(image.color(16, 4) == Color{0, 128, 0});
  CHECK(image.depth[0] == 0);
}

TEST_CASE("antialiasing takes the mean of four samples", "[render]") {
  RenderRig rig;
  rig.add(RenderShape::kSphere, {1, 0, 0}, {3, 0.2F, 0.1F});
  rig.add_light({1, 1, -1}, 0.5F);
  const CpuRendererOptions smooth{.antialias = true};
  const Image fine = rig.render(66, 42);
  const Image mean = rig.render(33, 21, smooth);
  for (int y = 0; y < 21; ++y) {
    for (int x = 0; x < 33; ++x) {
      int sum = 0;
      for (int i = 0; i < 4; ++i) sum += fine.color(2 * x + i % 2, 2 * y + i / 2)[0];
      CHECK(mean.color(x, y)[0] == (sum + 2) / 4);
    }
  }
  // Depth and segmentation keep to pixel centres.
  const Image plain = rig.render(33, 21);
  CHECK(mean.depth == plain.depth);
  CHECK(mean.segment == plain.segment);
}

TEST_CASE("shadows fall where light is blocked", "[render]") {
  RenderRig rig;
  rig.add(RenderShape::kPlane, {0, 0, 0}, {0, 0, -1});
  rig.add_light({0, 0, -1}, 0.5F, true);
  rig.set_camera({0, 0, 3}, look_along({0, 0, -1}, {1, 0, 0}));
  const Matrix3f slanted = turned(0.4F, {1, 0, 0});
  SECTION("sphere") { rig.add(RenderShape::kSphere, {0.5F, 0, 0}, {1, 0, 5}); }
  SECTION("ellipsoid") { rig.add(RenderShape::kEllipsoid, {0.5F, 0.5F, 1}, {1, 0, 5}); }
  SECTION("box") { rig.add(RenderShape::kBox, {0.5F, 0.5F, 0.5F}, {1, 0, 5}, slanted); }
  SECTION("capsule") { rig.add(RenderShape::kCapsule, {0.5F, 0.1F, 0}, {1, 0, 5}, slanted); }
  SECTION("cylinder") { rig.add(RenderShape::kCylinder, {0.5F, 0.5F, 0}, {1, 0, 5}, slanted); }
  CpuRendererOptions hard{.shadow_rays = 1};
  const Image image = rig.render(64, 64, hard);  // of 8 m x 8 m, with +x up; the geom is above
  CHECK(image.color(32, 24) == Color{128, 128, 128});
  CHECK(image.color(32, 40) == Color{255, 255, 255});
  CHECK(rig.render().color(32, 24) == Color{255, 255, 255});  // without the option
  hard.shadow_rays = 16;
  hard.shadow_softness = 0.1F;
  const Image soft = rig.render(64, 64, hard);
  int between = 0;
  for (int y = 0; y < 64; ++y) between += soft.color(32, y)[0] % 127 > 1 ? 1 : 0;
  CHECK(between > 3);
}

TEST_CASE("the ray caster says what is wrong with its arguments", "[render]") {
  RenderRig rig;
  rig.add(RenderShape::kBox, {1, 1, 1}, {4, 0, 0});
  CpuRendererOptions options;
  int workers = 1;
  SECTION("size of zero") { rig.scene.geoms[0].size[1] = 0; }
  SECTION("size that is no number") {
    rig.scene.geoms[0].size[1] = std::numeric_limits<float>::quiet_NaN();
  }
  SECTION("mesh that does not exist") { rig.scene.geoms[0].shape = RenderShape::kMesh; }
  SECTION("mesh with a hole in its indices") {
    rig.scene.meshes.push_back(box_mesh(1, 1, 1));
    rig.scene.meshes[0].triangles[3] = 8;
  }
  SECTION("mesh that is not convex") {
    rig.scene.meshes.push_back(box_mesh(1, 1, 1));
    for (int k = 0; k < 3; ++k) rig.scene.meshes[0].vertices[static_cast<std::size_t>(k)] = -0.1F;
  }
  SECTION("field of view") { rig.scene.cameras[0].fovy = 3.2F; }
  SECTION("near plane") { rig.scene.cameras[0].near_clip = 0; }
  SECTION("light without direction") { rig.add_light({0, 0, 0}, 1); }
  SECTION("too many lights") {
    for (int i = 0; i < 9; ++i) rig.add_light({0, 0, -1}, 0.1F);
  }
  SECTION("too many shadow rays") {
    for (int i = 0; i < 3; ++i) rig.add_light({0, 0, -1}, 0.1F, true);
    options.shadow_rays = 32;
  }
  SECTION("image size") { options.max_width = 0; }
  SECTION("workers") { workers = 0; }
  CHECK_THROWS_AS(make_cpu_renderer(rig.scene, options, workers), Error);
}

}  // namespace
}  // namespace engram::test
