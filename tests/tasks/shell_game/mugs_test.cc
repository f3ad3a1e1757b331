#include "tasks/shell_game/mugs.h"

#include <catch2/catch.hpp>

namespace engram {
namespace {

using tasks::check_mugs, tasks::kUpsideDown;

TEST_CASE("Mugs are the scene's first props, from left to right", "[shell]") {
  mjcf::Scene scene;
  const tasks::Mugs mugs(scene, {}, {&kUpsideDown, 1});
  REQUIRE(scene.props.size() == 3);
  CHECK(scene.props[0].name == "mug_left");
  CHECK(scene.props[2].name == "mug_right");
  CHECK(scene.props[2].pos[1] == Approx(0.2));
}

TEST_CASE("Mugs have to stand apart, and to hide their balls", "[shell]") {
  tasks::ShellGameParams params;
  CHECK_NOTHROW(check_mugs(params, kUpsideDown));
  params.BALL_RADIUS = 0.06;
  CHECK_THROWS_WITH(check_mugs(params, kUpsideDown), Catch::Contains("would not hide the ball"));
  params.BALL_RADIUS = 0.02;
  params.MUG_SCALE *= 3;
  CHECK_THROWS_WITH(check_mugs(params, kUpsideDown), Catch::Contains("do not stand apart"));
}

}  // namespace
}  // namespace engram
