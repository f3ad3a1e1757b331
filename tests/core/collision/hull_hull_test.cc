#include "core/collision/hull_hull.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <random>

namespace engram {
namespace {

constexpr double kReach = 0.01;  // m

const ConvexHull kCube = box_hull({0.02, 0.02, 0.02});
const ConvexHull kTable = box_hull({50, 50, 50});
const Frame kTableFrame = {{0, 0, -50}, Mat3::Identity()};

Mat3 turned(double angle, const Vec3& axis) {
  return Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix();
}

double min_gap(const ContactPoints& points) {
  double least = 1;
  for (const ContactPoint& point : points) least = std::min(least, point.gap);
  return least;
}

TEST_CASE("A standing hull has four points at its corners", "[contact]") {
  const Frame at = {{0.1, 0.2, 0.0205}, turned(0.4, Vec3::UnitZ())};
  const ContactPoints points = hull_hull({kCube, at}, {kTable, kTableFrame}, kReach);
  REQUIRE(points.size() == 4);
  for (const ContactPoint& point : points) {
    CHECK(point.gap == Approx(0.0005));
    CHECK(point.normal.isApprox(Vec3::UnitZ(), 1e-9));
    CHECK(point.pos.z() == Approx(0).margin(1e-9));
    CHECK((point.pos - Vec3(0.1, 0.2, 0)).norm() == Approx(0.02 * std::sqrt(2)));
  }
}

TEST_CASE("The order of hulls turns the normals only", "[contact]") {
  const Frame at = {{0, 0, 0.0195}, turned(0.3, {1, 0.2, 0})};
  const ContactPoints ab = hull_hull({kCube, at}, {kTable, kTableFrame}, kReach);
  const ContactPoints ba = hull_hull({kTable, kTableFrame}, {kCube, at}, kReach);
  REQUIRE(ab.size() > 0);
  REQUIRE(ab.size() == ba.size());
  CHECK(min_gap(ab) == Approx(min_gap(ba)));
  for (int i = 0; i < ab.size(); ++i) {
    CHECK(ab[i].normal.isApprox(Vec3::UnitZ(), 1e-9));
    CHECK(ba[i].normal.isApprox(-Vec3::UnitZ(), 1e-9));
    CHECK(ab[i].pos.z() == Approx(0).margin(1e-9));  // on the table
  }
}

TEST_CASE("Tilted hulls touch the table with their lowest corner", "[contact]") {
  std::mt19937 random(2);
  std::normal_distribution<double> normal;
  for (int round = 0; round < 30; ++round) {
    const Mat3 axes = turned(normal(random), {normal(random), normal(random), normal(random)});
    double lowest = 0;
    for (const Vec3& corner : kCube.corners) lowest = std::min(lowest, (axes * corner).z());
    const ContactPoints points =
        hull_hull({kCube, {{0, 0, -lowest - 0.001}, axes}}, {kTable, kTableFrame}, kReach);
    REQUIRE_FALSE(points.empty());
    CHECK(min_gap(points) == Approx(-0.001).margin(1e-8));
  }
}

TEST_CASE("Crossing edges touch in one point between them", "[contact]") {
  // Both stand on edges that cross at a right angle.
  const double half_diagonal = 0.02 * std::sqrt(2);
  const Frame below = {{0, 0, 0}, turned(std::numbers::pi / 4, Vec3::UnitX())};
  const Frame above = {{0.003, 0.004, 2 * half_diagonal - 0.0005},
                       turned(std::numbers::pi / 4, Vec3::UnitY())};
  const ContactPoints points = hull_hull({kCube, above}, {kCube, below}, kReach);
  REQUIRE(points.size() == 1);
  CHECK(points[0].gap == Approx(-0.0005));
  CHECK(points[0].normal.isApprox(Vec3::UnitZ(), 1e-9));
  CHECK(points[0].pos.isApprox(Vec3(0.003, 0, half_diagonal), 1e-9));
}

TEST_CASE("Separations never exceed distances, and distant hulls have no points", "[contact]") {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (int round = 0; round < 60; ++round) {
    const Vec3 away = 0.06 * Vec3(uniform(random), uniform(random), uniform(random));
    const Frame a = {away, turned(3 * uniform(random), {uniform(random), 0.3, uniform(random)})};
    const Frame b = {Vec3::Zero(), turned(uniform(random), Vec3::UnitY())};
    double nearest = 1;  // of many points of the surfaces
    for (int i = 0; i < 2000; ++i) {
      Vec3 p(uniform(random), uniform(random), uniform(random));
      p /= p.cwiseAbs().maxCoeff();
      const Vec3 local = b.axes.transpose() * (a.pos + a.axes * (0.02 * p));
      const Vec3 outside = local - local.cwiseMin(0.02).cwiseMax(-0.02);
      nearest = std::min(nearest, outside.norm());
    }
    CAPTURE(round);
    CHECK(hull_separation({kCube, a}, {kCube, b}) <= nearest + 1e-9);
    const ContactPoints points = hull_hull({kCube, a}, {kCube, b}, kReach);
    if (nearest == 0) CHECK(min_gap(points) < 0);
    if (nearest > std::sqrt(3) * kReach) CHECK(points.empty());
    for (const ContactPoint& point : points) {
      const Vec3 local = b.axes.transpose() * (point.pos - b.pos);
      CHECK(local.cwiseAbs().maxCoeff() <= 0.02 + 1e-9 - std::min(point.gap, 0.0));
    }
  }
}

TEST_CASE("Faces of many corners overlap in all of their area", "[contact]") {
  std::vector<Vec3> rim;
  for (int i = 0; i < 32; ++i) {
    const double angle = 2 * std::numbers::pi * i / 32;
    for (const double z : {-0.02, 0.02}) {
      rim.emplace_back(0.03 * std::cos(angle), 0.03 * std::sin(angle), z);
    }
  }
  const ConvexHull drum = convex_hull(rim);
  const ContactPoints points =
      hull_hull({drum, {{0.005, 0, 0.04}, turned(0.1, Vec3::UnitZ())}}, {drum, Frame{}}, kReach);
  REQUIRE(points.size() == 4);
  Vec3 mean = Vec3::Zero();
  for (const ContactPoint& point : points) {
    CHECK(point.gap == Approx(0).margin(1e-9));
    mean += point.pos / 4;
  }
  CHECK((mean - Vec3(0.0025, 0, 0.02)).norm() < 0.008);
}

}  // namespace
}  // namespace engram
