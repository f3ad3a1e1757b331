#include "mjcf/button.h"

#include <catch2/catch.hpp>
#include <string>

#include "tests/mjcf/model.h"

namespace engram::mjcf::test {
namespace {

TEST_CASE("A button is a square base and an upright cap, both firm", "[mjcf][button]") {
  ButtonShape shape;
  shape.BUTTON_BASE_HALF_SIZE = {0.04, 0.05, 0.015};
  shape.BUTTON_CAP_RADIUS = 0.025;
  Scene scene;
  scene.props = {button_base("b_base", shape), button_cap("b_cap", shape, 0.01)};
  const Model model = compile(scene, Detail::kFull);
  const Data data = make_data(model, kMikasa);
  const int base = id(model, mjOBJ_GEOM, "b_base_0");
  const int cap = id(model, mjOBJ_GEOM, "b_cap_0");
  CHECK(model->geom_type[base] == mjGEOM_BOX);
  CHECK(model->geom_type[cap] == mjGEOM_CYLINDER);
  CHECK(model->geom_size[3 * cap] == 0.025);
  CHECK(model->geom_size[3 * cap + 1] == 0.014);
  CHECK(data->geom_xpos[3 * base + 2] == Approx(0.015));
  CHECK(data->geom_xpos[3 * cap + 2] == Approx(0.044));
  CHECK(std::abs(data->geom_xmat[9 * cap + 8]) == Approx(1));  // its axis is the world's z
  for (const char* name : {"b_base", "b_cap"}) {
    const int body = id(model, mjOBJ_BODY, name);
    CHECK(model->body_mocapid[body] >= 0);
  }
  // Links that can come near collide with them.
  for (const int geom : {base, cap}) {
    int pairs = 0;
    for (int pair = 0; pair < model->npair; ++pair) {
      pairs += model->pair_geom1[pair] == geom || model->pair_geom2[pair] == geom ? 1 : 0;
    }
    CHECK(pairs > 5);
  }
}

}  // namespace
}  // namespace engram::mjcf::test
