#include "core/scene/physics_model.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <string>

#include "core/base/error.h"
#include "tests/core/scene/props.h"

namespace engram {
namespace {

TEST_CASE("Compiled scenes have collision geometry, no gravity and no drives", "[physics_model]") {
  const PhysicsModel& model = test::mixed_model();
  for (const mjModel* scene : {&model.full(), &model.robot()}) {
    CHECK(scene->npair > 0);
    CHECK(scene->nu == kRobotJoints);
    CHECK(scene->opt.gravity[2] == 0);
    for (int i = 0; i < kRobotJoints; ++i) {
      CHECK(scene->actuator_gainprm[i * mjNGAIN] == 0);
      CHECK(scene->dof_damping[i] == 0);
      CHECK(scene->jnt_limited[i] == 0);
    }
  }
  CHECK(model.robot().nq == kRobotJoints);
  CHECK(model.full().nq == kRobotJoints + 3 * 7);
  CHECK(model.full().nmocap == 1);
}

TEST_CASE("Constants of robot and props are the text's", "[physics_model]") {
  const PhysicsModel& model = test::mixed_model();
  CHECK(model.gravity() == Approx(9.81));
  CHECK(model.props()[test::kCube0].mass == Approx(0.064));
  CHECK(model.props()[test::kCube0].bounding_radius >= 0.02 * std::sqrt(3.0));
  CHECK(model.props()[test::kBall].bounding_radius == Approx(0.03).margin(1e-3));
  CHECK_FALSE(model.props()[test::kBox].free);
  CHECK(model.props()[test::kBox].tangible());
  CHECK(model.robot_params().drive.stiffness == 1000);
  CHECK(model.robot_params().timestep == Approx(0.01));
  CHECK(model.robot_params().upper[kArmJoints] == Approx(0.04));
}

TEST_CASE("Shapes that reach props are those of the hand and its neighbours", "[physics_model]") {
  const PhysicsModel& model = test::mixed_model();
  REQUIRE_FALSE(model.reach_shapes().empty());
  REQUIRE(model.reach_boxes().size() == model.reach_shapes().size());
  bool finger = false;
  for (std::size_t i = 0; i < model.reach_shapes().size(); ++i) {
    const CollisionShape& shape =
        model.collision().shapes()[static_cast<std::size_t>(model.reach_shapes()[i])];
    const CollisionBody& body = model.collision().bodies()[static_cast<std::size_t>(shape.body)];
    CHECK(body.kind == BodyKind::kLink);
    CHECK(model.reach_boxes()[i].bounding_radius() >= 0.99 * shape.half.maxCoeff());
    finger = finger || finger_of(body.link) >= 0;
  }
  CHECK(finger);
  CHECK(std::is_sorted(model.reach_shapes().begin(), model.reach_shapes().end()));
}

TEST_CASE("A prop that the scene lacks is refused by its name", "[physics_model]") {
  SceneSpec spec = tasks::scene_source(test::mixed_scene());
  spec.props.front() = "sphinx";
  CHECK_THROWS_WITH(PhysicsModel(spec), Catch::Contains("without a body named 'sphinx'"));
}

}  // namespace
}  // namespace engram
