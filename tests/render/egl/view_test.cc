// Draw lists of the OpenGL renderer.
#include "render/egl/view.h"

#include <catch2/catch.hpp>

#include "tests/render/render_fixture.h"

namespace engram::test {
namespace {

int instances_in_view(const RenderRig& rig) {
  const gl::Shapes shapes(rig.scene.meshes);
  gl::DrawList list(rig.scene, shapes);
  const gl::Viewpoint view = gl::camera_viewpoint(rig.scene, rig.instances(), 0, 64, 64);
  list.fill_for_camera(rig.instances(), view, 0.1F);
  int count = 0;
  for (const gl::DrawCall& call : list.draws()) count += call.count;
  return count;
}

TEST_CASE("A draw list has the visible geoms before the camera", "[render][egl]") {
  RenderRig rig;
  rig.add(RenderShape::kBox, {0.1F, 0.1F, 0.1F}, {2, 0, 0});
  rig.add(RenderShape::kSphere, {0.1F, 0, 0}, {3, 0.5F, 0});
  rig.add(RenderShape::kBox, {0.1F, 0.1F, 0.1F}, {-2, 0, 0});  // behind
  CHECK(instances_in_view(rig) == 2);
  rig.visible[0] = 0;
  CHECK(instances_in_view(rig) == 1);
  rig.rgba[4 + 3] = 0;  // the sphere, transparent
  CHECK(instances_in_view(rig) == 0);
}

TEST_CASE("A camera's view has the middle of the image where it points", "[render][egl]") {
  RenderRig rig;
  const gl::Viewpoint view = gl::camera_viewpoint(rig.scene, rig.instances(), 0, 64, 32);
  const Eigen::Vector4f clip = view.clip_from_world * Eigen::Vector4f(2, 0, 0, 1);
  CHECK(clip.x() / clip.w() == Approx(0).margin(1e-6));
  CHECK(clip.y() / clip.w() == Approx(0).margin(1e-6));
  CHECK(view.slope_x == Approx(2 * view.slope_y));
}

}  // namespace
}  // namespace engram::test
