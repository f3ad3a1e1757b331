#include "core/scene/collision_scene.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <set>
#include <string>
#include <utility>

#include "core/base/error.h"
#include "core/scene/physics_model.h"
#include "tests/core/scene/props.h"

namespace engram {
namespace {

const CollisionScene& scene() { return test::mixed_model().collision(); }
const CollisionShape& shape(int i) { return scene().shapes()[static_cast<std::size_t>(i)]; }
const CollisionBody& body(int i) { return scene().bodies()[static_cast<std::size_t>(i)]; }
const CollisionBody& body_of_shape(int i) { return body(shape(i).body); }
const CollisionBody& prop(int i) { return body(scene().body_of_prop(i)); }

TEST_CASE("Bodies are links, props and what is static", "[collision_scene]") {
  CHECK(prop(test::kCube0).kind == BodyKind::kFree);
  CHECK(prop(test::kBall).kind == BodyKind::kFree);
  CHECK(prop(test::kBox).kind == BodyKind::kKinematic);
  CHECK(prop(test::kCube1).prop == test::kCube1);
  std::set<int> links;
  int fixed = 0;
  for (const CollisionBody& one : scene().bodies()) {
    CHECK((one.kind == BodyKind::kLink) == (one.link >= 0));
    if (one.link >= 0) {
      CHECK(links.insert(one.link).second);
      CHECK(one.attachment.link >= 0);
    }
    fixed += one.kind == BodyKind::kStatic ? 1 : 0;
  }
  CHECK(links.contains(kLeftFingerLink));
  CHECK(links.contains(kRightFingerLink));
  CHECK(links.contains(kHandLink));
  CHECK(links.contains(kArmJoints - 1));
  CHECK(fixed >= 1);
}

TEST_CASE("A prop of which nothing collides has no body", "[collision_scene]") {
  mjcf::Scene mixed = test::mixed_scene();
  for (mjcf::Geom& geom : mixed.props[test::kBox].geoms) geom.collides = false;
  const PhysicsModel model(tasks::scene_source(mixed));
  CHECK(model.collision().body_of_prop(test::kBox) == -1);
  CHECK(model.collision().body_of_prop(test::kCube1) >= 0);
  CHECK_FALSE(model.props()[test::kBox].tangible());
}

TEST_CASE("Shapes have the geoms' sizes, in their body's frame", "[collision_scene]") {
  const CollisionShape& cube = shape(prop(test::kCube0).first_shape);
  CHECK(prop(test::kCube0).num_shapes == 1);
  CHECK(cube.type == mjGEOM_BOX);
  CHECK(cube.half.isApprox(Vec3::Constant(0.02)));
  CHECK(cube.frame.pos.norm() < 1e-12);
  CHECK(shape(prop(test::kBall).first_shape).type == mjGEOM_SPHERE);
  CHECK(shape(prop(test::kBall).first_shape).half.x() == Approx(0.03));
  for (const CollisionBody& one : scene().bodies()) {
    for (int i = one.first_shape; i < one.first_shape + one.num_shapes; ++i) {
      const double farthest =
          (shape(i).frame.pos - one.bounding_center).norm() + shape(i).bounding_radius;
      CHECK(one.bounding_radius >= farthest - 1e-12);
      CHECK(&body_of_shape(i) == &one);
    }
  }
}

TEST_CASE("The table is the top of a large box", "[collision_scene]") {
  int planes = 0;
  for (const CollisionShape& one : scene().shapes()) {
    if (one.type != mjGEOM_PLANE) continue;
    ++planes;
    CHECK((one.frame.pos + one.frame.axes * Vec3(0, 0, one.half.z())).z() ==
          Approx(0).margin(1e-9));
    CHECK(one.half.minCoeff() > 10);
  }
  CHECK(planes == 1);
}

TEST_CASE("In a pair links come before props, and props before what is fixed",
          "[collision_scene]") {
  const auto rank = [](const CollisionBody& one) {
    if (one.kind == BodyKind::kLink) return 0;
    return one.kind == BodyKind::kFree ? 1 : 2;
  };
  std::set<std::pair<int, int>> props;  // of the task
  for (const ShapePair& pair : scene().shape_pairs()) {
    const CollisionBody& a = body_of_shape(pair.a);
    const CollisionBody& b = body_of_shape(pair.b);
    CHECK(rank(a) <= rank(b));
    CHECK(rank(a) < 2);  // something moves
    CHECK(&a != &b);
    if (a.prop >= 0 && b.prop >= 0) props.insert(std::minmax(a.prop, b.prop));
  }
  CHECK(props == std::set<std::pair<int, int>>{{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}});
}

TEST_CASE("Pairs of two bodies lie together, those of moving bodies first", "[collision_scene]") {
  int next = 0;
  bool fixed_before = false;
  std::set<std::pair<int, int>> seen;
  for (const BodyPair& pair : scene().body_pairs()) {
    CHECK(pair.first == next);
    CHECK(pair.count > 0);
    next += pair.count;
    for (int i = pair.first; i < pair.first + pair.count; ++i) {
      const ShapePair& shapes = scene().shape_pairs()[static_cast<std::size_t>(i)];
      CHECK(shape(shapes.a).body == pair.a);
      CHECK(shape(shapes.b).body == pair.b);
    }
    CHECK(seen.emplace(pair.a, pair.b).second);
    const BodyKind kind = body(pair.b).kind;
    const bool fixed = kind == BodyKind::kStatic || kind == BodyKind::kKinematic;
    CHECK((fixed || !fixed_before));
    fixed_before = fixed;
  }
  CHECK(next == static_cast<int>(scene().shape_pairs().size()));
}

TEST_CASE("Fingers alone have torsional friction", "[collision_scene]") {
  int rubber = 0;
  for (const ShapePair& pair : scene().shape_pairs()) {
    const bool finger =
        finger_of(body_of_shape(pair.a).link) >= 0 || finger_of(body_of_shape(pair.b).link) >= 0;
    CHECK(pair.friction == Approx(finger ? 1.15 : 0.3));
    CHECK(pair.torsion_radius == Approx(finger ? 0.1 : 0));
    rubber += finger ? 1 : 0;
  }
  CHECK(rubber > 0);
}

TEST_CASE("A robot with a body that is none of its links is refused", "[collision_scene]") {
  SceneSpec spec = tasks::scene_source({});
  std::string text = spec.compose({}, RobotDetail::kCollision);
  for (std::size_t at = 0; (at = text.find("\"link5\"", at)) != std::string::npos; ++at) {
    text.replace(at, 7, "\"elbow\"");
  }
  const ModelPtr model = compile_model(text);
  CHECK_THROWS_WITH(CollisionScene(*model, {}), Catch::Contains("'elbow'"));
}

}  // namespace
}  // namespace engram
