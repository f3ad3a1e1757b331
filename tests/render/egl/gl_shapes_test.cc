#include "render/egl/gl_shapes.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "tests/render/render_fixture.h"

namespace engram::test {
namespace {

using gl::Shapes, gl::Vertex;

RenderGeom geom_of(RenderShape shape) {
  RenderGeom geom;
  geom.shape = shape;
  geom.mesh = 0;
  return geom;
}

TEST_CASE("Triangles of every shape face outwards, as their normals do", "[render]") {
  const Shapes shapes({box_mesh(0.5F, 0.5F, 0.5F)});
  for (const RenderShape shape :
       {RenderShape::kPlane, RenderShape::kSphere, RenderShape::kCapsule, RenderShape::kEllipsoid,
        RenderShape::kCylinder, RenderShape::kBox, RenderShape::kMesh}) {
    const int index = shapes.part_of(geom_of(shape), 2);
    const gl::ShapePart& part = shapes.parts()[static_cast<std::size_t>(index)];
    CAPTURE(static_cast<int>(shape));
    REQUIRE(part.index_count > 0);
    for (std::uint32_t i = 0; i < part.index_count; i += 3) {
      Eigen::Vector3f point[3];
      Eigen::Vector3f normal = Eigen::Vector3f::Zero();
      for (std::uint32_t k = 0; k < 3; ++k) {
        const std::uint32_t at = shapes.indices()[part.first_index + i + k];
        const Vertex& vertex = shapes.vertices()[static_cast<std::size_t>(part.first_vertex) + at];
        point[k] = Eigen::Map<const Eigen::Vector3f>(vertex.position);
        point[k].z() += vertex.end;  // capsules: half length 1
        normal += Eigen::Map<const Eigen::Vector3f>(vertex.normal);
      }
      const Eigen::Vector3f face = (point[1] - point[0]).cross(point[2] - point[0]);
      if (face.norm() > 1e-6F) REQUIRE(face.dot(normal) > 0);
    }
  }
}

TEST_CASE("Larger round shapes have finer outlines, up to the finest", "[render]") {
  CHECK(gl::level_for(1, 0.1F) == 0);
  CHECK(gl::level_for(1e6F, 0.1F) == gl::kLevels - 1);
  int before = 0;
  for (float radius = 1; radius < 1000; radius *= 2) {
    const int level = gl::level_for(radius, 0.1F);
    CHECK(level >= before);
    CHECK(gl::level_for(radius, 1) <= level);
    before = level;
  }
}

}  // namespace
}  // namespace engram::test
