#include "mjcf/prop_body.h"

#include <catch2/catch.hpp>

#include "tests/mjcf/model.h"

namespace engram::mjcf::test {
namespace {

TEST_CASE("Off-diagonal inertia and centre of mass reach the model", "[mjcf][prop_body]") {
  Prop prop = cube("odd", 0.02, {1, 0, 0, 1});
  prop.center_of_mass = {0.001, -0.002, 0.003};
  prop.inertia = {2e-5, 3e-5, 4e-5, 1e-6, -2e-6, 3e-6};
  const Model model = compile({{prop}}, Detail::kPhysics);
  const int body = id(model, mjOBJ_BODY, "odd");
  CHECK(model->body_ipos[3 * body + 1] == -0.002);
  const mjtNum* inertia = model->body_inertia + 3 * body;
  CHECK(inertia[0] + inertia[1] + inertia[2] == Approx(9e-5));
}

TEST_CASE("Emission, colour and visibility reach the visual geoms only", "[mjcf][prop_body]") {
  Prop lamp = cube("lamp", 0.02, {0, 1, 0, 1});
  lamp.geoms[0].emission = 0.7;
  lamp.geoms.push_back({.type = GeomType::kSphere, .size = {0.03, 0, 0}, .visible = false});
  lamp.geoms.push_back({.type = GeomType::kCylinder,
                        .size = {0.01, 0.02, 0},
                        .rgba = {1, 0, 1, 1},
                        .collides = false});
  const Model full = compile({{lamp}}, Detail::kFull);
  const int bulb = id(full, mjOBJ_GEOM, "lamp_0");
  CHECK(full->mat_emission[full->geom_matid[bulb]] == Approx(0.7));
  CHECK(full->geom_rgba[4 * bulb + 1] == 1);
  CHECK(full->geom_group[bulb] == 2);
  CHECK(full->geom_group[id(full, mjOBJ_GEOM, "lamp_1")] == 3);
  CHECK(full->geom_rgba[4 * bulb] == 0);
  CHECK(full->geom_rgba[4 * id(full, mjOBJ_GEOM, "lamp_2") + 1] < 0.03F);

  const Model physics = compile({{lamp}}, Detail::kPhysics);
  CHECK(mj_name2id(physics.get(), mjOBJ_GEOM, "lamp_1") >= 0);
  CHECK(mj_name2id(physics.get(), mjOBJ_GEOM, "lamp_2") == -1);
}

TEST_CASE("Base colours are encoded with the display's curve", "[mjcf][prop_body]") {
  const Prop prop = cube("cube", 0.02, {1, 128 / 255.0, 20 / 255.0, 1});
  const Model full = compile({{prop}}, Detail::kFull);
  const float* rgba = full->geom_rgba + 4 * id(full, mjOBJ_GEOM, "cube_0");
  // The original shows these colours in the same light as 231, 169, 73.
  CHECK(rgba[0] == 1);
  CHECK(rgba[1] == Approx(169.0 / 231).epsilon(0.01));
  CHECK(rgba[2] == Approx(73.0 / 231).epsilon(0.01));
}

}  // namespace
}  // namespace engram::mjcf::test
