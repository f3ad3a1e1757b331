// Contact points of boxes against those of the original.
#include "core/collision/narrow_phase.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "core/scene/physics_model.h"
#include "tasks/common/task_info.h"
#include "tests/core/contact/recorded_contacts.h"

namespace engram {
namespace {

using test::RecordedBody, test::RecordedPoint, test::RecordedRun, test::RecordedSubstep,
    test::Recordings;

// Pairs of boxes of a run, found in every recorded substep.
class Finder {
 public:
  explicit Finder(const RecordedRun& run)
      : model_(tasks::scene_source({.props = test::recorded_props(run)})),
        narrow_phase_(model_.full(), model_.collision()) {}

  struct Counts {
    int pairs = 0;  // that the original has with an impulse
    int alike = 0;  // of the same number, order, normal, points and gaps
    int points = 0;
    int nearer = 0;  // points that are nearer than their pair's separation
  };

  void compare(const RecordedSubstep& at, Counts& counts) {
    const CollisionScene& scene = model_.collision();
    for (std::size_t i = 0; i < scene.shape_pairs().size(); ++i) {
      const ShapePair& pair = scene.shape_pairs()[i];
      Frame a;
      Frame b;
      if (!pose(pair.a, at, a) || !pose(pair.b, at, b)) continue;
      const ContactPoints found =
          narrow_phase_.find(static_cast<int>(i), a, b, kContactReach, memory_[i]);
      const double apart = narrow_phase_.separation(static_cast<int>(i), a, b) - 1e-12;
      counts.nearer += static_cast<int>(
          std::count_if(found.begin(), found.end(),
                        [&](const ContactPoint& point) { return point.gap < apart; }));
      const std::vector<RecordedPoint> theirs = recorded(pair, at);
      const bool pushes = std::any_of(theirs.begin(), theirs.end(),
                                      [](const RecordedPoint& point) { return point.impulse > 0; });
      if (!pushes) continue;
      ++counts.pairs;
      counts.points += static_cast<int>(theirs.size());
      counts.alike += alike(found, theirs) ? 1 : 0;
    }
  }

 private:
  std::string body_name(int shape) const {
    const CollisionScene& scene = model_.collision();
    const int geom = scene.shapes()[static_cast<std::size_t>(shape)].geom;
    const int body = model_.full().geom_bodyid[geom];
    return body == 0 ? "table" : mj_id2name(&model_.full(), mjOBJ_BODY, body);
  }
  // Number of a finger's box.
  std::string finger_box(int shape) const {
    if (!body_name(shape).ends_with("finger")) return "";
    const CollisionScene& scene = model_.collision();
    const std::string name = mj_id2name(&model_.full(), mjOBJ_GEOM,
                                        scene.shapes()[static_cast<std::size_t>(shape)].geom);
    return name.substr(name.size() - 1);
  }

  bool pose(int shape, const RecordedSubstep& at, Frame& frame) const {
    const CollisionShape& of = model_.collision().shapes()[static_cast<std::size_t>(shape)];
    if (of.type != mjGEOM_BOX && of.type != mjGEOM_PLANE) return false;
    const std::string name = body_name(shape);
    Frame body;
    if (name.ends_with("finger")) {
      if (at.robot.empty()) return false;
      const RobotPose robot = pose_at(model_.robot_model(), at.robot.front().qpos.data());
      body =
          carried(robot, model_.collision().bodies()[static_cast<std::size_t>(of.body)].attachment);
    } else if (name != "table") {
      const auto found = std::find_if(at.bodies.begin(), at.bodies.end(),
                                      [&](const RecordedBody& b) { return b.name == name; });
      if (found == at.bodies.end()) return false;
      body = {found->pos, found->quat.toRotationMatrix()};
    }
    frame = {body.pos + body.axes * of.frame.pos, body.axes * of.frame.axes};
    return true;
  }

  std::vector<RecordedPoint> recorded(const ShapePair& pair, const RecordedSubstep& at) const {
    std::vector<RecordedPoint> points;
    std::copy_if(at.points.begin(), at.points.end(), std::back_inserter(points),
                 [&](const RecordedPoint& point) {
                   return point.a == body_name(pair.a) && point.b == body_name(pair.b) &&
                          point.shape == finger_box(pair.a);
                 });
    return points;
  }

  static bool alike(const ContactPoints& found, const std::vector<RecordedPoint>& theirs) {
    if (found.size() != static_cast<int>(theirs.size())) return false;
    for (int i = 0; i < found.size(); ++i) {
      const RecordedPoint& point = theirs[static_cast<std::size_t>(i)];
      if (found[i].normal.dot(point.normal) < std::cos(0.8 * 3.14159265 / 180)) return false;
      if ((found[i].pos - point.pos).norm() > 2e-4) return false;
      if (std::abs(found[i].gap - point.gap) > 5e-5) return false;
    }
    return true;
  }

  PhysicsModel model_;
  NarrowPhase narrow_phase_;
  std::map<std::size_t, ContactPair> memory_;
};

TEST_CASE("Boxes have the original's contact points", "[physics][original]") {
  Finder::Counts counts;
  for (const auto& [name, run] : Recordings::runs()) {
    if (name.starts_with("battery") || name.starts_with("ball")) continue;
    Finder finder(run);
    for (const auto& [substep, at] : run) {
      if (!at.points.empty()) finder.compare(at, counts);
    }
  }
  CHECK(counts.pairs > 500);
  // The others lag by up to a millimetre: the original found them one substep earlier or later.
  CHECK(counts.alike >= 0.97 * counts.pairs);
  INFO(counts.alike << " of " << counts.pairs << ", " << counts.points << " points");
  CHECK(counts.points > 2000);
  CHECK(counts.nearer == 0);
}

TEST_CASE("Shapes other than boxes have MuJoCo's contact points, on the surface of B",
          "[physics]") {
  const RecordedRun& run = Recordings::runs().at("ball_vs_fingers_1.0_off0.000");
  const PhysicsModel model(tasks::scene_source({.props = test::recorded_props(run)}));
  NarrowPhase narrow_phase(model.full(), model.collision());
  const CollisionScene& scene = model.collision();
  for (std::size_t i = 0; i < scene.shape_pairs().size(); ++i) {
    const ShapePair& pair = scene.shape_pairs()[i];
    const CollisionShape& ball = scene.shapes()[static_cast<std::size_t>(pair.a)];
    const CollisionShape& table = scene.shapes()[static_cast<std::size_t>(pair.b)];
    if (ball.type != mjGEOM_SPHERE || table.type != mjGEOM_PLANE) continue;
    ContactPair memory;
    const ContactPoints points =
        narrow_phase.find(static_cast<int>(i), {Vec3(0.1, 0.2, 0.05), Mat3::Identity()},
                          table.frame, kContactReach, memory);
    REQUIRE(points.size() == 1);
    CHECK(points[0].gap == Approx(0.03));
    CHECK(points[0].normal.isApprox(Vec3::UnitZ()));
    CHECK(points[0].pos.isApprox(Vec3(0.1, 0.2, 0), 1e-12));
  }
}

// MuJoCo's collision of convex shapes is exact only up to a margin well below their sizes.
TEST_CASE("The gap of a ball to a cylinder is exact wherever the ball is near", "[contact]") {
  constexpr double kBall = 0.02;      // m
  constexpr double kCylinder = 0.04;  // m
  mjcf::Prop post;
  post.name = "post";
  post.geoms.push_back({.type = mjcf::GeomType::kCylinder, .size = {kCylinder, 0.06, 0}});
  post.body_type = mjcf::BodyType::kKinematic;
  mjcf::Scene props;
  props.props = {mjcf::ball("ball", kBall, {1, 1, 1, 1}), post};
  const PhysicsModel model(tasks::scene_source(props));
  const CollisionScene& scene = model.collision();
  const auto prop_of = [&](int shape) {
    const int body = scene.shapes()[static_cast<std::size_t>(shape)].body;
    return scene.bodies()[static_cast<std::size_t>(body)].prop;
  };
  NarrowPhase narrow_phase(model.full(), scene);
  const MujocoScope scope;
  int pairs = 0;
  for (std::size_t i = 0; i < scene.shape_pairs().size(); ++i) {
    const ShapePair& pair = scene.shape_pairs()[i];
    if (prop_of(pair.a) != 0 || prop_of(pair.b) != 1) continue;
    ++pairs;
    for (const double gap : {0.009, 0.006, 0.003, 0.001, 0.0, -0.0005}) {
      CAPTURE(gap);
      ContactPair memory;
      const Frame ball = {Vec3(0, -kCylinder - kBall - gap, 0.02), Mat3::Identity()};
      const ContactPoints points = narrow_phase.find(
          static_cast<int>(i), ball, {Vec3(0, 0, 0.06), Mat3::Identity()}, 0.012, memory);
      REQUIRE(points.size() == 1);
      CHECK(points[0].gap == Approx(gap).margin(1e-5));
      CHECK(points[0].normal.isApprox(-Vec3::UnitY(), 1e-3));
    }
  }
  CHECK(pairs == 1);
}

}  // namespace
}  // namespace engram
