// The nine shapes in the engine: they land, fall asleep, wake when touched and only then.
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "mjcf/object_shapes.h"
#include "tests/core/sim/physics_fixture.h"

namespace engram {
namespace {

using mjcf::ObjectShape, test::Placement, test::Rig;

mjcf::Prop shape(ObjectShape which, int index) {
  return mjcf::shape_prop("shape_" + std::to_string(index), which, {0, 0, 1, 1});
}

// All nine in three rows of 0.07 m, out of the arm's way.
struct Nine {
  explicit Nine(PropStatus status, const std::function<double(ObjectShape)>& height) {
    for (int i = 0; i < mjcf::kObjectShapeCount; ++i) {
      const auto which = static_cast<ObjectShape>(i);
      props.push_back(shape(which, i));
      const double row = i / 3;
      placements.push_back({{0.05 + 0.07 * (i % 3), -0.3 + 0.07 * row, height(which)}, status});
    }
  }
  std::vector<mjcf::Prop> props;
  std::vector<Placement> placements;
};

TEST_CASE("Shapes that appear in the air land, fall asleep and lie at rest", "[sleep][shapes]") {
  const Nine nine(PropStatus::kAwake, [](ObjectShape) { return 0.02; });
  Rig rig(nine.props, nine.placements);
  rig.rest(12);
  for (int i = 0; i < mjcf::kObjectShapeCount; ++i) {
    const auto which = static_cast<ObjectShape>(i);
    INFO(mjcf::shape_name(which));
    CHECK(rig.status(i) == PropStatus::kAsleep);
    CHECK(rig.pos(i).z() == Approx(mjcf::resting_height(which)).margin(1e-4));
    const Eigen::Vector3d start = nine.placements[static_cast<std::size_t>(i)].pos;
    CHECK((rig.pos(i) - start).head<2>().norm() < 1e-5);
  }
}

TEST_CASE("Shapes woken at rest fall asleep again where they were", "[sleep][shapes]") {
  const Nine nine(PropStatus::kAwake, mjcf::resting_height);
  Rig rig(nine.props, nine.placements);
  rig.rest(8);
  for (int i = 0; i < mjcf::kObjectShapeCount; ++i) {
    INFO(mjcf::shape_name(static_cast<ObjectShape>(i)));
    CHECK(rig.status(i) == PropStatus::kAsleep);
    CHECK((rig.pos(i) - nine.placements[static_cast<std::size_t>(i)].pos).norm() < 2e-5);
  }
}

// A cross comes down between a torus, in whose bounding sphere it lands, and a cube.
struct Neighbours {
  explicit Neighbours(double height)
      : rig({shape(ObjectShape::kCross, 0), shape(ObjectShape::kTorus, 1),
             shape(ObjectShape::kCube, 2)},
            {{{0.1, 0.1, height}, PropStatus::kAwake}, {torus}, {cube}}) {}

  const Eigen::Vector3d torus = {0.1, 0.1 + 0.03 + 0.02707107 + 0.001,
                                 mjcf::resting_height(ObjectShape::kTorus)};
  const Eigen::Vector3d cube = {0.1 + 0.03 + 0.02 + 0.001, 0.1, 0.02};
  Rig rig;
};

TEST_CASE("A prop that lies awake a millimetre beside others leaves them asleep",
          "[sleep][shapes]") {
  Neighbours beside(mjcf::resting_height(ObjectShape::kCross));
  for (int i = 0; i < 12; ++i) {
    beside.rig.rest(1);
    CHECK(beside.rig.status(1) == PropStatus::kAsleep);
    CHECK(beside.rig.status(2) == PropStatus::kAsleep);
  }
  CHECK(beside.rig.status(0) == PropStatus::kAsleep);
}

// It wakes them: in a substep it may move farther than the distance between them.
TEST_CASE("A prop that falls a millimetre beside others leaves them where they are",
          "[sleep][shapes]") {
  Neighbours beside(0.02);
  beside.rig.rest(12);
  for (int i = 0; i < 3; ++i) CHECK(beside.rig.status(i) == PropStatus::kAsleep);
  CHECK(beside.rig.pos(0).z() == Approx(0.0075).margin(1e-4));
  CHECK((beside.rig.pos(1) - beside.torus).norm() < 2e-5);
  CHECK((beside.rig.pos(2) - beside.cube).norm() < 2e-5);
}

// Pushes a shape along x with the closed gripper, low over the table, and goes away.
Eigen::Vector3d push(ObjectShape which, bool sleep) {
  const BatchOptions options{.sleep = sleep};
  const double height = mjcf::resting_height(which);
  Rig rig({shape(which, 0)}, {{{0.0, 0.0, height}}}, options);
  rig.move({-0.08, 0, 0.08}, 30, -0.6);
  rig.move({-0.08, 0, 0.015}, 20, -0.6);
  CHECK((rig.pos(0) - Eigen::Vector3d(0, 0, height)).norm() < (sleep ? 1e-15 : 1e-5));
  CHECK((rig.status(0) == PropStatus::kAsleep) == sleep);
  for (int i = 0; i < 24; ++i) rig.move({-0.08 + 0.005 * (i + 1), 0, 0.015}, 1, -0.6, 0.3F);
  rig.move({0.04, 0, 0.3}, 40, -0.6);
  CHECK((rig.status(0) == PropStatus::kAsleep) == sleep);
  CHECK(rig.pos(0).z() == Approx(height).margin(3e-4));
  return rig.pos(0);
}

TEST_CASE("Shapes of many parts are pushed as without sleep and come to rest", "[sleep][shapes]") {
  for (const ObjectShape which : {ObjectShape::kCross, ObjectShape::kTorus, ObjectShape::kStar,
                                  ObjectShape::kPyramide, ObjectShape::kTShape}) {
    INFO(mjcf::shape_name(which));
    const Eigen::Vector3d on = push(which, true);
    const Eigen::Vector3d off = push(which, false);
    CAPTURE(on.transpose(), off.transpose());
    CHECK(on.x() > 0.02);
    // MuJoCo's contacts of boxes with cylinders are coarse: rounding decides by how many
    // millimetres a torus slides on.
    CHECK((on - off).norm() < (which == ObjectShape::kTorus ? 1e-2 : 2e-3));
  }
}

}  // namespace
}  // namespace engram
