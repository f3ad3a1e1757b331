// Scenes of a few props, for tests of compiled models.
#pragma once

#include <algorithm>
#include <array>
#include <string>

#include "core/scene/physics_model.h"
#include "mjcf/ball.h"
#include "mjcf/object_shapes.h"
#include "mjcf/scene.h"
#include "tasks/common/task_info.h"

namespace engram::test {

// Start pose of the robot: seven joints, two fingers.
inline constexpr std::array kStartPose = {0.0,       0.0,        0.0,  -2.0943951, 0.0,
                                          2.0943951, 0.78539816, 0.04, 0.04};

inline mjcf::Prop named_cube(const std::string& name) {
  return mjcf::cube(name, 0.02, {1, 0, 0, 1});
}

// Two cubes, a ball and a kinematic box, in this order.
inline mjcf::Scene mixed_scene() {
  mjcf::Scene scene;
  scene.props = {named_cube("cube_0"), mjcf::ball("ball", 0.03, {0, 1, 0, 1}), named_cube("cube_1"),
                 named_cube("box")};
  scene.props.back().body_type = mjcf::BodyType::kKinematic;
  return scene;
}
inline constexpr int kCube0 = 0;
inline constexpr int kBall = 1;
inline constexpr int kCube1 = 2;
inline constexpr int kBox = 3;

inline const PhysicsModel& mixed_model() {
  static const PhysicsModel model(tasks::scene_source(mixed_scene()));
  return model;
}

}  // namespace engram::test
