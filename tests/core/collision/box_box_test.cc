#include "core/collision/box_box.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

namespace engram {
namespace {

constexpr double kReach = 0.04;  // m

BoxPose box(const Vec3& half, const Vec3& pos, double angle = 0, const Vec3& axis = Vec3::UnitZ()) {
  return {half, {pos, Eigen::AngleAxisd(angle, axis).toRotationMatrix()}};
}
const Vec3 kCube = Vec3::Constant(0.02);
const BoxPose kTable = box({0.6, 1.2, 0.5}, {0, 0, -0.5});

TEST_CASE("A cube on the table touches it with its four corners in order", "[contact]") {
  const ContactPoints points = box_box(box(kCube, {0.1, 0.2, 0.021}), kTable, kReach);
  REQUIRE(points.size() == 4);
  const double expected[4][2] = {{0.12, 0.22}, {0.12, 0.18}, {0.08, 0.18}, {0.08, 0.22}};
  for (int i = 0; i < 4; ++i) {
    CHECK(points[i].pos.isApprox(Vec3(expected[i][0], expected[i][1], 0), 1e-9));
    CHECK(points[i].normal.isApprox(Vec3::UnitZ()));
    CHECK(points[i].gap == Approx(0.001));
  }
}

TEST_CASE("An edge has points up to the reach above the table", "[contact]") {
  const double angle = std::numbers::pi / 6;
  const double lowest = 0.02 * (std::cos(angle) + std::sin(angle));
  const ContactPoints points =
      box_box(box(kCube, {0, 0, lowest}, angle, Vec3::UnitX()), kTable, kReach);
  REQUIRE(points.size() == 4);
  int touching = 0;
  for (const ContactPoint& point : points) {
    CHECK(point.gap < kReach);
    touching += std::abs(point.gap) < 1e-12 ? 1 : 0;
  }
  CHECK(touching == 2);
}

TEST_CASE("Boxes farther apart than the reach have no contact", "[contact]") {
  CHECK(box_box(box(kCube, {0, 0, 0.061}), kTable, kReach).empty());
  CHECK(box_box(box(kCube, {0, 0, 0}), box(kCube, {0.1, 0, 0}), kReach).empty());
  // Beside one another and above one another at once: no face covers the other.
  CHECK(box_box(box(kCube, {0, 0, 0}), box(kCube, {0.045, 0, 0.045}), kReach).empty());
  for (const double side : {-1.0, 1.0}) {
    for (const auto& [beside, count] : {std::pair(0.0399, 4), std::pair(0.0401, 0)}) {
      const BoxPose along_x = box(kCube, {side * beside, 0, 0.041});
      const BoxPose along_y = box(kCube, {0, side * beside, 0.041});
      CHECK(box_box(along_x, box(kCube, {0, 0, 0}), kReach).size() == count);
      CHECK(box_box(along_y, box(kCube, {0, 0, 0}), kReach).size() == count);
    }
  }
}

TEST_CASE("Points lie on the second box, the normal leads to the first", "[contact]") {
  const ContactPoints points =
      box_box(box(kCube, {0, 0, 0}), box(kCube, {0.039, 0.005, 0}), kReach);
  REQUIRE(points.size() == 4);
  for (const ContactPoint& point : points) {
    CHECK(point.gap == Approx(-0.001));
    CHECK(point.normal.isApprox(-Vec3::UnitX()));
    CHECK(point.pos.x() == Approx(0.019));
  }
}

TEST_CASE("More than four points are reduced to the deepest and the most spread", "[contact]") {
  const double eighth = std::numbers::pi / 4;  // an octagon of overlap
  const ContactPoints points =
      box_box(box(kCube, {0, 0, 0.0395}, eighth), box(kCube, {0, 0, 0}), kReach);
  REQUIRE(points.size() == 4);
  for (const ContactPoint& point : points) CHECK(point.gap == Approx(-0.0005));
  CHECK((points[0].pos - points[1].pos).norm() > 0.03);
}

}  // namespace
}  // namespace engram
