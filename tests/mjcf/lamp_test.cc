// The lamp: sizes, and physics without it.
#include "mjcf/lamp.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "mjcf/scene.h"
#include "tests/core/sim/physics_fixture.h"

namespace engram {
namespace {

double half_height(const mjcf::Geom& p) {
  if (p.type == mjcf::GeomType::kSphere) return p.size[0];
  return p.type == mjcf::GeomType::kCylinder ? p.size[1] : p.size[2];
}

TEST_CASE("The lamp is as tall and wide as measured", "[mjcf][lamp]") {
  const mjcf::Prop body = mjcf::lamp_body("body");
  const mjcf::Prop bulb = mjcf::lamp_bulb("bulb");
  const auto top = [](const mjcf::Prop& prop) {
    double highest = 0;
    for (const auto& p : prop.geoms) highest = std::max(highest, p.pos[2] + half_height(p));
    return highest;
  };
  const auto width = [](const mjcf::Prop& prop) {
    double widest = 0;
    for (const auto& p : prop.geoms) widest = std::max(widest, p.size[0]);
    return widest;
  };
  CHECK(top(body) == Approx(0.0624));  // the collar's upper side
  CHECK(top(bulb) == Approx(0.113));
  CHECK(width(body) == Approx(0.0216));
  CHECK(width(bulb) == Approx(0.031));
  for (const mjcf::Prop& prop : {body, bulb}) {
    CHECK(prop.body_type == mjcf::BodyType::kKinematic);
    for (const auto& p : prop.geoms) CHECK_FALSE(p.collides);
  }
}

TEST_CASE("Visual props cost physics nothing and change no bit", "[mjcf][lamp]") {
  const mjcf::Prop cube = mjcf::cube("cube", 0.02, {1, 0, 0, 1});
  const test::Placement cube_place{{0.0, 0.05, 0.02}};
  const test::Placement lamp_place{{-0.07, 0, 0.06}};  // where the tool goes down
  test::Rig with({mjcf::lamp_body("body"), cube, mjcf::lamp_bulb("bulb")},
                 {lamp_place, cube_place, lamp_place});
  test::Rig without({cube}, {cube_place});

  const PhysicsModel& model = with.batch().physics_model();
  const CollisionScene& scene = model.collision();
  CHECK(scene.shape_pairs().size() ==
        without.batch().physics_model().collision().shape_pairs().size());
  CHECK(scene.body_of_prop(0) == -1);
  CHECK(scene.body_of_prop(1) >= 0);
  CHECK(scene.body_of_prop(2) == -1);
  CHECK_FALSE(model.props()[0].tangible());
  CHECK(model.props()[1].tangible());
  CHECK_FALSE(model.props()[2].tangible());

  for (int step = 0; step < 40; ++step) {
    const Eigen::Vector3d goal(-0.07, 0.03 * std::sin(0.3 * step), 0.07);
    with.move(goal, 1);
    without.move(goal, 1);
    const double* a = with.state().qpos.row(0);
    const double* b = without.state().qpos.row(0);
    REQUIRE(std::equal(a, a + kRobotJoints, b));
    REQUIRE(with.pos(1) == without.pos(0));
  }
  CHECK(with.tcp().z() < 0.09);  // through the lamp
}

}  // namespace
}  // namespace engram
