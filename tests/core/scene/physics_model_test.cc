#include "core/scene/physics_model.h"

#include <catch2/catch.hpp>
#include <numeric>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "tests/core/scene/props.h"

namespace engram {
namespace {

std::vector<int> count_of(const PhysicsModel& model, const std::vector<int>& props) {
  std::vector<int> count(static_cast<std::size_t>(model.num_types()), 0);
  for (const int prop : props) {
    ++count[static_cast<std::size_t>(model.props()[static_cast<std::size_t>(prop)].type)];
  }
  return count;
}

TEST_CASE("Scenes grow from the robot's dynamics to the whole scene", "[physics_model]") {
  const PhysicsModel& model = test::mixed_model();
  CHECK(model.scenes()[PhysicsModel::kDynamicsScene].model->npair == 0);
  CHECK(model.scenes()[PhysicsModel::kRobotScene].slots.empty());
  CHECK(model.robot().npair > 0);
  CHECK(model.scenes().back().slots.size() == 3);
  for (const SceneModel& scene : model.scenes()) CHECK(scene.model->nu == kRobotJoints);
}

TEST_CASE("The smallest scene has slots for what is awake, and no smaller one has",
          "[physics_model]") {
  const PhysicsModel& model = test::mixed_model();
  CHECK(model.smallest_scene(count_of(model, {}), false) == PhysicsModel::kRobotScene);
  CHECK(model.smallest_scene(count_of(model, {0, 1, 2}), true) == model.full_scene());
  for (const std::vector<int>& awake : std::vector<std::vector<int>>{{0}, {1}, {0, 1}, {0, 2}}) {
    const std::vector<int> count = count_of(model, awake);
    const int scene = model.smallest_scene(count, true);
    const SceneModel& chosen = model.scenes()[static_cast<std::size_t>(scene)];
    CHECK(chosen.has_slots_for(count));
    CHECK(chosen.has_kinematic_props);
    CHECK(chosen.slots.size() == awake.size());
  }
  const int kinematic = model.smallest_scene(count_of(model, {}), true);
  CHECK(model.scenes()[static_cast<std::size_t>(kinematic)].has_kinematic_props);
  CHECK(model.scenes()[static_cast<std::size_t>(kinematic)].slots.empty());
}

TEST_CASE("Constants of robot and props are the text's", "[physics_model]") {
  const PhysicsModel& model = test::mixed_model();
  CHECK(model.gravity() == Approx(9.81));
  CHECK(model.props()[test::kCube0].mass == Approx(0.064));
  CHECK(model.props()[test::kCube0].bounding_radius >= 0.02 * std::sqrt(3.0));
  CHECK(model.props()[test::kBall].bounding_radius == Approx(0.03).margin(1e-3));
  CHECK_FALSE(model.props()[test::kBox].free);
  CHECK(model.props()[test::kBox].tangible());
  CHECK(model.props()[test::kCube0].type == model.props()[test::kCube1].type);
  CHECK(model.num_types() == 3);
  CHECK_FALSE(model.reach_geoms().empty());
  CHECK(model.reach_boxes().size() == model.reach_geoms().size());
}

TEST_CASE("Robot geometry that reaches props is the same in all scenes", "[physics_model]") {
  const PhysicsModel& model = test::mixed_model();
  for (std::size_t i = PhysicsModel::kRobotScene; i < model.scenes().size(); ++i) {
    const mjModel& scene = *model.scenes()[i].model;
    for (const int geom : model.reach_geoms()) {
      CHECK(scene.geom_bodyid[geom] == model.full().geom_bodyid[geom]);
      CHECK(scene.geom_rbound[geom] == model.full().geom_rbound[geom]);
    }
    CHECK(std::string(mj_id2name(&scene, mjOBJ_BODY, model.finger_bodies()[0])) == "leftfinger");
  }
}

TEST_CASE("A specification without a type for each prop is refused", "[physics_model]") {
  SceneSpec spec = tasks::scene_source(test::mixed_scene());
  spec.types.pop_back();
  CHECK_THROWS_WITH(PhysicsModel(spec), Catch::Contains("one type for each prop"));
}

}  // namespace
}  // namespace engram
