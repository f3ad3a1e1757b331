#include "core/image/scene_from_model.h"

#include <catch2/catch.hpp>
#include <string>

#include "core/base/error.h"
#include "core/scene/mujoco_handle.h"
#include "render/cpu/cpu_renderer.h"
#include "tests/allocation_counter.h"

namespace engram::test {
namespace {

const char* const kModel = R"(
<mujoco>
  <visual>
    <headlight ambient="0.3 0.2 0.1" diffuse="0 0 0"/>
    <map znear="0.02" zfar="40"/>
  </visual>
  <statistic extent="2"/>
  <asset>
    <texture name="half" type="2d" builtin="flat" rgb1="1 0.5 0" width="16" height="16"/>
    <material name="dark wood" texture="half"/>
    <material name="floor" rgba="0.4 0.4 0.4 1"/>
    <material name="lamp" rgba="0 1 0 1" emission="0.7"/>
    <mesh name="wedge" vertex="0 0 0  1 0 0  0 1 0  0 0 1  0.1 0.1 0.1"/>
  </asset>
  <worldbody>
    <light directional="true" dir="0 0 -2" diffuse="0.5 0.6 0.7" ambient="0.1 0.1 0.1"
           castshadow="false"/>
    <light directional="false" diffuse="1 1 1" pos="0 0 3"/>
    <camera name="eye" pos="-3 0 1" xyaxes="0 -1 0 0 0 1" fovy="60"/>
    <geom type="plane" size="5 5 1" material="floor"/>
    <geom type="box" size="1 2 0.1" material="dark wood" group="2"/>
    <geom type="sphere" size="0.1" group="3"/>
    <geom type="sphere" size="0.1" rgba="1 0 0 0"/>
    <body name="arm" pos="0 0 1" quat="1 0 0 1">
      <freejoint/>
      <geom type="capsule" size="0.1 0.2" pos="0.5 0 0" material="lamp"/>
      <geom type="mesh" mesh="wedge" rgba="0.1 0.2 0.3 1"/>
      <camera name="hand" pos="0 0 0.1" fovy="90"/>
    </body>
  </worldbody>
</mujoco>)";

TEST_CASE("a model's scene has its visible geoms, cameras and lights", "[render]") {
  const ModelPtr model = compile_model(kModel);
  const ModelScene result = scene_from_model(*model);
  const RenderScene& scene = result.scene;

  REQUIRE(scene.geoms.size() == 4);
  CHECK(result.model_geom == std::vector<int>{0, 1, 4, 5});
  CHECK(result.geom_body == std::vector<int>{0, 0, 1, 1});
  CHECK(scene.geoms[0].pattern == RenderPattern::kGrid);
  CHECK(scene.geoms[1].pattern == RenderPattern::kWood);
  CHECK(scene.geoms[2].shape == RenderShape::kCapsule);
  CHECK(scene.geoms[2].size[1] == 0.2F);
  CHECK(scene.geoms[2].segment == 5);
  CHECK(result.emission == std::vector<float>{0, 0, 0.7F, 0});
  CHECK(result.rgba[4] == 1);
  CHECK(result.rgba[5] == Approx(0.5).margin(0.01));
  CHECK(result.rgba[14] == 0.3F);
  REQUIRE(scene.meshes.size() == 1);
  CHECK(scene.geoms[3].mesh == 0);

  REQUIRE(scene.cameras.size() == 2);
  CHECK(scene.cameras[0].name == "eye");
  CHECK(scene.cameras[0].fovy == Approx(1.0471976));
  CHECK(scene.cameras[0].near_clip == Approx(0.04));
  CHECK(scene.cameras[0].far_clip == Approx(80));

  REQUIRE(scene.lights.size() == 1);
  CHECK(scene.lights[0].direction[2] == Approx(-1));
  CHECK(scene.lights[0].color[2] == 0.7F);
  CHECK(scene.ambient[0] == Approx(0.4));
  CHECK_NOTHROW(make_cpu_renderer(scene, {}, 1));
}

TEST_CASE("geoms and cameras move with their bodies", "[render]") {
  const ModelPtr model = compile_model(kModel);
  const DataPtr data = make_data(*model);
  data->qpos[0] = 0.25;
  data->qpos[4] = 0.5;
  mj_normalizeQuat(model.get(), data->qpos);
  mj_forward(model.get(), data.get());
  const ModelScene scene = scene_from_model(*model);
  std::vector<float> geoms(12 * scene.scene.geoms.size());
  std::vector<float> cameras(12 * scene.scene.cameras.size());
  std::vector<Frame> bodies;
  for (int body = 0; body < model->nbody; ++body) {
    bodies.push_back(make_frame(data->xpos + 3 * body, data->xquat + 4 * body));
  }
  const std::int64_t before = allocation_count();
  pose_geoms(scene, bodies.data(), geoms.data());
  pose_cameras(scene, bodies.data(), cameras.data());
  CHECK(allocation_count() == before);

  for (std::size_t i = 0; i < scene.model_geom.size(); ++i) {
    const int geom = scene.model_geom[i];
    for (std::size_t k = 0; k < 9; ++k) {
      CHECK(geoms[12 * i + k] ==
            Approx(data->geom_xmat[9 * geom + static_cast<int>(k)]).margin(1e-6));
    }
    for (std::size_t k = 0; k < 3; ++k) {
      CHECK(geoms[12 * i + 9 + k] ==
            Approx(data->geom_xpos[3 * geom + static_cast<int>(k)]).margin(1e-6));
    }
  }
  for (std::size_t k = 0; k < 9; ++k) {
    CHECK(cameras[12 + k] == Approx(data->cam_xmat[9 + static_cast<int>(k)]).margin(1e-6));
  }

  // Rows of hidden geoms are left alone.
  std::vector<std::uint8_t> visible(scene.scene.geoms.size(), 1);
  visible[1] = 0;
  std::vector<float> some(geoms.size(), 7);
  pose_geoms(scene, bodies.data(), some.data(), visible.data());
  for (std::size_t i = 0; i < geoms.size(); ++i) CHECK(some[i] == (i / 12 == 1 ? 7 : geoms[i]));
}

TEST_CASE("a model with a height field cannot be drawn", "[render]") {
  const ModelPtr model = compile_model(R"(
    <mujoco>
      <asset><hfield name="hills" nrow="4" ncol="4" size="1 1 1 0.1"/></asset>
      <worldbody><geom type="hfield" hfield="hills"/></worldbody>
    </mujoco>)");
  CHECK_THROWS_AS(scene_from_model(*model), Error);
}

}  // namespace
}  // namespace engram::test
