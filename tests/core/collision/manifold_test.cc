#include "core/collision/manifold.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

namespace engram {
namespace {

constexpr double kReach = 0.04;    // m
constexpr double kHalf = 0.02;     // m, of a cube on the table
constexpr double kMargin = 0.003;  // m, 0.15 of it

BoxPose cube_at(const Vec3& offset, double degrees = 0, const Vec3& axis = Vec3::UnitZ()) {
  const double angle = degrees * std::numbers::pi / 180;
  return {Vec3::Constant(kHalf),
          {Vec3(0, 0, kHalf) + offset, Eigen::AngleAxisd(angle, axis).toRotationMatrix()}};
}
const BoxPose kTable = {{0.6, 1.2, 0.5}, {Vec3(0, 0, -0.5), Mat3::Identity()}};
const ManifoldLimits kLimits = manifold_limits(Vec3::Constant(kHalf), kTable.half);

Manifold resting(const BoxPose& cube = cube_at(Vec3::Zero())) {
  Manifold manifold;
  find_manifold(manifold, cube, kTable, kReach);
  return manifold;
}
bool needs_search(const BoxPose& moved) {
  Manifold manifold = resting();
  return refresh_manifold(manifold, moved, kTable, kLimits);
}

TEST_CASE("An unknown manifold has to be found", "[contact]") {
  Manifold manifold;
  CHECK(refresh_manifold(manifold, cube_at(Vec3::Zero()), kTable, kLimits));
  find_manifold(manifold, cube_at(Vec3::Zero()), kTable, kReach);
  CHECK(manifold.num_points == 4);
  CHECK_FALSE(refresh_manifold(manifold, cube_at(Vec3::Zero()), kTable, kLimits));
}

TEST_CASE("The margin is a share of the smallest half extent, up to 15 mm", "[contact]") {
  CHECK(kLimits.margin == Approx(kMargin));
  CHECK(manifold_limits({0.01, 0.3, 0.3}, {0.5, 0.5, 0.008}).margin == Approx(0.15 * 0.008));
  CHECK(manifold_limits(Vec3::Constant(1), Vec3::Constant(2)).margin == 0.015);
}

TEST_CASE("Four points are kept while a cube moves less than 3/8 of the margin", "[contact]") {
  const double most = 0.375 * kMargin;
  for (const Vec3& axis : {Vec3(1, 0, 0), Vec3(0, -1, 0), Vec3(0, 0, 1)}) {
    CHECK_FALSE(needs_search(cube_at(0.99 * most * axis)));
    CHECK(needs_search(cube_at(1.01 * most * axis)));
  }
}

TEST_CASE("Four points are kept while a cube turns less than the cosine 0.9999 allows",
          "[contact]") {
  const double most = 2 * std::acos(0.9999) * 180 / std::numbers::pi;  // degrees
  for (const Vec3& axis : {Vec3(0, 0, 1), Vec3(1, 0, 0)}) {
    CHECK_FALSE(needs_search(cube_at(Vec3::Zero(), 0.99 * most, axis)));
    CHECK(needs_search(cube_at(Vec3::Zero(), 1.01 * most, axis)));
  }
}

TEST_CASE("Both boxes may move together", "[contact]") {
  Manifold manifold = resting();
  const Vec3 far(1, 2, 3);
  BoxPose table = kTable;
  table.frame.pos += far;
  CHECK_FALSE(refresh_manifold(manifold, cube_at(far), table, kLimits));
  const ContactPoints points = manifold_points(manifold, cube_at(far), table, kReach);
  REQUIRE(points.size() == 4);
  CHECK(points[0].pos.z() == Approx(3));
  CHECK(points[0].gap == Approx(0).margin(1e-12));
}

TEST_CASE("A point that has slid away is dropped, and the manifold found anew", "[contact]") {
  Manifold manifold = resting();
  CHECK_FALSE(refresh_manifold(manifold, cube_at(Vec3::Zero()), kTable, kLimits));
  CHECK(manifold.num_points == 4);
  CHECK(refresh_manifold(manifold, cube_at({0.81 * kMargin, 0, 0}), kTable, kLimits));
  CHECK(manifold.num_points == 0);
  // Turned about one corner, those far from it slide.
  manifold = resting();
  const Vec3 corner(kHalf, kHalf, 0);
  const Mat3 turn = Eigen::AngleAxisd(0.05, Vec3::UnitZ()).toRotationMatrix();
  const BoxPose turned = {Vec3::Constant(kHalf),
                          {corner + turn * (Vec3(0, 0, kHalf) - corner), turn}};
  CHECK(refresh_manifold(manifold, turned, kTable, kLimits));
  CHECK(manifold.num_points == 3);
}

TEST_CASE("Kept points move with the boxes, and their gaps with them", "[contact]") {
  const Manifold manifold = resting();
  const ContactPoints lifted = manifold_points(manifold, cube_at({0, 0, 0.001}), kTable, kReach);
  REQUIRE(lifted.size() == 4);
  for (const ContactPoint& point : lifted) {
    CHECK(point.gap == Approx(0.001));
    CHECK(point.normal.isApprox(Vec3::UnitZ()));
    CHECK(point.pos.z() == Approx(0).margin(1e-12));
  }
  CHECK(manifold_points(manifold, cube_at({0, 0, 1.01 * kReach}), kTable, kReach).empty());
}

TEST_CASE("Boxes without points are searched again after half the margin", "[contact]") {
  const BoxPose apart = cube_at({0, 0, 1.5 * kReach});
  Manifold manifold = resting(apart);
  CHECK(manifold.known);
  CHECK(manifold.num_points == 0);
  CHECK_FALSE(
      refresh_manifold(manifold, cube_at({0, 0, 1.5 * kReach - 0.49 * kMargin}), kTable, kLimits));
  CHECK(
      refresh_manifold(manifold, cube_at({0, 0, 1.5 * kReach - 0.51 * kMargin}), kTable, kLimits));
}

TEST_CASE("Quaternions of axes have a positive first component", "[contact]") {
  for (double angle = 0; angle < 6.3; angle += 0.1) {
    const Mat3 axes = Eigen::AngleAxisd(angle, Vec3(1, 2, -3).normalized()).toRotationMatrix();
    const Eigen::Vector4d quat = manifold_quat(axes);
    REQUIRE(quat[0] >= 0);
    REQUIRE(Quat(quat[0], quat[1], quat[2], quat[3]).toRotationMatrix().isApprox(axes, 1e-12));
  }
}

}  // namespace
}  // namespace engram
