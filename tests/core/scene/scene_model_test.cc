#include "core/scene/scene_model.h"

#include <array>
#include <catch2/catch.hpp>
#include <set>
#include <vector>

#include "core/base/error.h"
#include "core/robot/robot_params.h"
#include "tests/core/scene/props.h"

namespace engram {
namespace {

SceneSpec mixed_spec() { return tasks::scene_source(test::mixed_scene()); }

SceneModel compile_all() {
  return compile_scene(mixed_spec(), std::array{0, 1, 2, 3}, RobotDetail::kCollision);
}

TEST_CASE("Slots of a scene are in the order of types and name their bodies", "[scene]") {
  const SceneModel scene = compile_all();
  REQUIRE(scene.slots.size() == 3);
  CHECK(scene.slots[0].type == scene.slots[1].type);
  CHECK(scene.slots[1].type < scene.slots[2].type);
  CHECK(scene.has_kinematic_props);
  CHECK(scene.free_bodies.size() == 3);
  for (std::size_t i = 0; i < scene.slots.size(); ++i) {
    const PropSlot& slot = scene.slots[i];
    CHECK(scene.slot_of_body[static_cast<std::size_t>(slot.body)] == static_cast<int>(i));
    CHECK(is_free_body(*scene.model, slot.body));
    CHECK(slot.dof >= kRobotJoints);
  }
  CHECK(scene.mocap[test::kBox] >= 0);
  CHECK(scene.mocap[test::kCube0] == -1);
}

TEST_CASE("A scene has slots for as many props of a type as it was compiled with", "[scene]") {
  const SceneModel scene = compile_all();
  const auto cube = static_cast<std::size_t>(scene.slots[0].type);
  const auto ball = static_cast<std::size_t>(scene.slots[2].type);
  std::vector<int> count(4, 0);
  CHECK(scene.has_slots_for(count));
  count[cube] = 2;
  count[ball] = 1;
  CHECK(scene.has_slots_for(count));
  count[ball] = 2;
  CHECK_FALSE(scene.has_slots_for(count));
}

TEST_CASE("A finger is moved by the arm and by its own joint, a prop by none", "[scene]") {
  const SceneModel scene = compile_all();
  const mjModel& model = *scene.model;
  const auto joints_of = [&](const char* name) {
    return scene.joints_of_body[static_cast<std::size_t>(mj_name2id(&model, mjOBJ_BODY, name))];
  };
  constexpr unsigned kArm = (1U << kArmJoints) - 1;
  CHECK(joints_of("leftfinger") == (kArm | 1U << kArmJoints));
  CHECK(joints_of("rightfinger") == (kArm | 1U << (kArmJoints + 1)));
  CHECK(joints_of("link0") == 0);
  CHECK(joints_of("cube_0") == 0);
  CHECK(joints_of("box") == 0);
}

TEST_CASE("The engine's own dynamics are taken out of the model", "[scene]") {
  const SceneModel scene = compile_all();
  CHECK(scene.model->opt.gravity[2] == 0);
  for (int joint = 0; joint < kRobotJoints; ++joint) {
    CHECK(scene.model->dof_armature[joint] == 0);
    CHECK(scene.model->dof_damping[joint] == 0);
    CHECK(scene.model->jnt_limited[joint] == 0);
  }
}

TEST_CASE("A scene that the contact step cannot simulate is refused", "[scene]") {
  const SceneSpec spec = mixed_spec();
  const std::array props = {0};
  const auto compile = [&] { return compile_model(spec.compose(props, RobotDetail::kCollision)); };
  SECTION("pyramidal cones") {
    ModelPtr model = compile();
    model->opt.cone = mjCONE_PYRAMIDAL;
    CHECK_THROWS_WITH(make_scene(std::move(model), spec, props), Catch::Contains("elliptic"));
  }
  SECTION("another solver") {
    ModelPtr model = compile();
    model->opt.solver = mjSOL_CG;
    CHECK_THROWS_WITH(make_scene(std::move(model), spec, props), Catch::Contains("Newton"));
  }
  SECTION("a missing prop") {
    CHECK_THROWS_WITH(make_scene(compile(), spec, std::array{test::kBall}),
                      Catch::Contains("ball"));
  }
  SECTION("no robot") {
    CHECK_THROWS_AS(make_scene(compile_model("<mujoco><worldbody/></mujoco>"), spec, props), Error);
  }
}

TEST_CASE("Subsets hold every combination of types once", "[scene]") {
  const std::array free_props = {test::kCube0, test::kBall, test::kCube1};
  const std::vector<std::vector<int>> subsets = scene_subsets(mixed_spec(), free_props, 20);
  // One prop: a cube or the ball. Two: both cubes, or a cube and the ball.
  CHECK(subsets.size() == 4);
  CHECK(std::set<std::vector<int>>(subsets.begin(), subsets.end()).size() == subsets.size());
  for (const std::vector<int>& subset : subsets) {
    CHECK(std::is_sorted(subset.begin(), subset.end()));
    CHECK(subset.size() < free_props.size());
  }
  CHECK(scene_subsets(mixed_spec(), free_props, 2).size() == 2);
  CHECK(scene_subsets(mixed_spec(), free_props, 1).empty());
}

}  // namespace
}  // namespace engram
