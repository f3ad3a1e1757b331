#include "core/collision/cylinder_box.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <random>

namespace engram {
namespace {

constexpr double kReach = 0.01;       // m
constexpr double kRadius = 0.02;      // m
constexpr double kHalfHeight = 0.05;  // m
constexpr double kRight = std::numbers::pi / 2;

BoxPose box(const Vec3& half, const Vec3& pos) { return {half, {pos, Mat3::Identity()}}; }
const BoxPose kTable = box({0.6, 1.2, 0.5}, {0, 0, -0.5});

CylinderPose cylinder(const Vec3& pos, double angle = 0, const Vec3& axis = Vec3::UnitX()) {
  return {kRadius, kHalfHeight, {pos, Eigen::AngleAxisd(angle, axis).toRotationMatrix()}};
}

TEST_CASE("A standing cylinder has four points on its rim", "[contact]") {
  const ContactPoints points = cylinder_box(cylinder({0.1, 0.2, 0.051}), kTable, kReach);
  REQUIRE(points.size() == 4);
  Vec3 mean = Vec3::Zero();
  for (const ContactPoint& point : points) {
    CHECK(point.gap == Approx(0.001));
    CHECK(point.normal.isApprox(Vec3::UnitZ()));
    CHECK((point.pos - Vec3(0.1, 0.2, 0)).norm() == Approx(kRadius));
    mean += point.pos / 4;
  }
  CHECK(mean.isApprox(Vec3(0.1, 0.2, 0), 1e-9));
}

TEST_CASE("A lying cylinder touches in the ends of a line at any roll", "[contact]") {
  for (const double roll : {0.0, 0.3, 1.0, 2.5}) {
    CylinderPose lying = cylinder({0, 0, kRadius - 0.0005}, kRight);
    lying.frame.axes = lying.frame.axes * Eigen::AngleAxisd(roll, Vec3::UnitZ());
    const ContactPoints points = cylinder_box(lying, kTable, kReach);
    REQUIRE(points.size() == 2);
    for (const ContactPoint& point : points) {
      CHECK(point.gap == Approx(-0.0005));
      CHECK(point.pos.x() == Approx(0).margin(1e-9));
      CHECK(std::abs(point.pos.y()) == Approx(kHalfHeight));
    }
  }
}

TEST_CASE("A tilted cylinder touches with its lowest point of the rim first", "[contact]") {
  for (const double tilt : {0.2, 0.5, 0.9, 1.3}) {
    const double lowest = kHalfHeight * std::cos(tilt) + kRadius * std::sin(tilt);
    const ContactPoints points = cylinder_box(cylinder({0, 0, lowest}, tilt), kTable, kReach);
    REQUIRE_FALSE(points.empty());
    double least = kReach;
    for (const ContactPoint& point : points) least = std::min(least, point.gap);
    CHECK(least == Approx(0).margin(1e-9));
  }
}

TEST_CASE("What hangs over the table's edge has no point beyond it", "[contact]") {
  const ContactPoints standing = cylinder_box(cylinder({0.59, 0, 0.05}), kTable, kReach);
  REQUIRE(standing.size() >= 3);
  for (const ContactPoint& point : standing) CHECK(point.pos.x() <= 0.6 + 1e-9);
  const ContactPoints lying =
      cylinder_box(cylinder({0.58, 0, kRadius}, kRight, Vec3::UnitY()), kTable, kReach);
  REQUIRE(lying.size() == 2);
  const double last = std::max(lying[0].pos.x(), lying[1].pos.x());
  CHECK(last == Approx(0.6));
}

TEST_CASE("A small box on a cap touches with its four corners", "[contact]") {
  const ContactPoints points = cylinder_box(
      cylinder({0, 0, 0}), box(Vec3::Constant(0.01), {0.002, 0, kHalfHeight + 0.0095}), kReach);
  REQUIRE(points.size() == 4);
  for (const ContactPoint& point : points) {
    CHECK(point.gap == Approx(-0.0005));
    CHECK(point.normal.isApprox(-Vec3::UnitZ()));  // from the box to the cylinder
    CHECK(point.pos.z() == Approx(kHalfHeight - 0.0005));
    CHECK(std::abs(point.pos.x() - 0.002) == Approx(0.01));
  }
}

TEST_CASE("A finger's face against the round side touches along the axis", "[contact]") {
  const ContactPoints points = cylinder_box(
      cylinder({0, 0, 0}), box({0.01, 0.01, 0.008}, {0, kRadius + 0.0099, 0.02}), kReach);
  REQUIRE(points.size() == 2);
  for (const ContactPoint& point : points) {
    CHECK(point.normal.isApprox(-Vec3::UnitY()));
    CHECK(point.gap == Approx(-0.0001));
    CHECK(std::abs(point.pos.z() - 0.02) == Approx(0.008));
  }
}

TEST_CASE("An upright edge against the round side touches in the ends of a line", "[contact]") {
  BoxPose turned = box({0.01, 0.01, 0.03}, {0, 0, 0});
  turned.frame.axes = Eigen::AngleAxisd(kRight / 2, Vec3::UnitZ()).toRotationMatrix();
  const double corner = 0.01 * std::numbers::sqrt2;
  turned.frame.pos = {kRadius + corner - 0.0002, 0, 0};
  const ContactPoints points = cylinder_box(cylinder({0, 0, 0}), turned, kReach);
  REQUIRE(points.size() == 2);
  for (const ContactPoint& point : points) {
    CHECK(point.gap == Approx(-0.0002));
    CHECK(point.normal.isApprox(-Vec3::UnitX(), 1e-6));
  }
}

TEST_CASE(
    "Apart by more than the reach there is no point, and the separation is below the distance",
    "[contact]") {
  CHECK(cylinder_box(cylinder({0, 0, 0.0601}), kTable, kReach).empty());
  CHECK(cylinder_box_separation(cylinder({0, 0, 0.06}), kTable) == Approx(0.01));
  CHECK(cylinder_box_separation(cylinder({0, 0, 0.04}), kTable) == Approx(-0.01));
}

// Distance by sampling the cylinder's surface.
double sampled_distance(const CylinderPose& cylinder, const BoxPose& box) {
  double least = 1;
  const auto consider = [&](const Vec3& local) {
    const Vec3 world = cylinder.frame.pos + cylinder.frame.axes * local;
    const Vec3 p = box.frame.axes.transpose() * (world - box.frame.pos);
    least = std::min(least, (p - p.cwiseMin(box.half).cwiseMax(-box.half)).norm());
  };
  for (int turn = 0; turn < 120; ++turn) {
    const double angle = 2 * std::numbers::pi * turn / 120;
    const double x = std::cos(angle);
    const double y = std::sin(angle);
    for (int k = -30; k <= 30; ++k) {
      consider({kRadius * x, kRadius * y, kHalfHeight * k / 30});
    }
    for (int k = 0; k <= 20; ++k) {
      consider({kRadius * x * k / 20, kRadius * y * k / 20, kHalfHeight});
      consider({kRadius * x * k / 20, kRadius * y * k / 20, -kHalfHeight});
    }
  }
  return least;
}

TEST_CASE("At random poses the separation never exceeds the distance, and what touches has points",
          "[contact]") {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> uniform(-1, 1);
  const BoxPose cube = box(Vec3::Constant(0.02), Vec3::Zero());
  int near = 0;
  for (int i = 0; i < 200; ++i) {
    const Vec3 axis(uniform(random), uniform(random), uniform(random));
    const Vec3 pos(0.08 * uniform(random), 0.08 * uniform(random), 0.08 * uniform(random));
    const CylinderPose pose = cylinder(pos, kRight * uniform(random), axis.normalized());
    const double distance = sampled_distance(pose, cube);
    CHECK(cylinder_box_separation(pose, cube) <= distance + 1e-6);
    const ContactPoints points = cylinder_box(pose, cube, kReach);
    if (distance < 1e-9) {  // they overlap
      ++near;
      INFO(i << ' ' << pos.transpose() << " sep " << cylinder_box_separation(pose, cube) << " axis "
             << pose.frame.axes.col(2).transpose());
      CHECK_FALSE(points.empty());
      double least = kReach;
      for (const ContactPoint& point : points) least = std::min(least, point.gap);
      CHECK(least <= 0.001);
    }
    if (distance > kReach + 0.003) CHECK(points.empty());
  }
  CHECK(near > 20);
}

}  // namespace
}  // namespace engram
