#include "render/cpu/prepared_scene.h"

#include <catch2/catch.hpp>

#include "core/base/error.h"
#include "tests/render/render_fixture.h"

namespace engram::test {
namespace {

TEST_CASE("The hull of a box has its six faces", "[render]") {
  const cpu::Hull hull = cpu::make_hull(box_mesh(0.1F, 0.2F, 0.3F), "box");
  CHECK(hull.center.norm() < 1e-7);
  CHECK((hull.half - Eigen::Vector3d(0.1, 0.2, 0.3)).norm() < 1e-7);
  REQUIRE(hull.normals.size() == hull.offsets.size());
  for (std::size_t i = 0; i < hull.normals.size(); ++i) {
    CHECK(hull.normals[i].cwiseAbs().maxCoeff() == Approx(1));
    CHECK(hull.offsets[i] == Approx(hull.normals[i].cwiseAbs().dot(hull.half)));
  }
}

TEST_CASE("A mesh with a dent has no hull", "[render]") {
  RenderMesh mesh = box_mesh(1, 1, 1);
  for (std::size_t k = 0; k < 3; ++k) mesh.vertices[k] = -0.1F;
  CHECK_THROWS_WITH(cpu::make_hull(mesh, "dent"), Catch::Contains("dent"));
}

TEST_CASE("Only lights that cast shadows get rays, and only if shadows are asked for", "[render]") {
  RenderRig rig;
  rig.add(RenderShape::kBox, {1, 1, 1}, {4, 0, 0});
  rig.add_light({0, 0, -1}, 0.5F, true);
  rig.add_light({1, 0, -1}, 0.5F, false);
  CpuRendererOptions options;
  CHECK_FALSE(cpu::PreparedScene(rig.scene, options).casts_shadows());
  options.shadow_rays = 4;
  const cpu::PreparedScene prepared(rig.scene, options);
  CHECK(prepared.casts_shadows());
  CHECK(prepared.rays[0].size() == 4);
  CHECK(prepared.rays[1].empty());
}

}  // namespace
}  // namespace engram::test
