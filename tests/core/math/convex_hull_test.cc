#include "core/math/convex_hull.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <random>

#include "core/base/error.h"

namespace engram {
namespace {

// A hull is closed, and all points are inside of its faces.
void check_sound(const ConvexHull& hull, const std::vector<Vec3>& points, double tolerance) {
  const int corners = static_cast<int>(hull.corners.size());
  const int edges = static_cast<int>(hull.edges.size());
  const int faces = static_cast<int>(hull.faces.size());
  CHECK(corners - edges + faces == 2);
  for (const ConvexHull::Face& face : hull.faces) {
    CHECK(face.count >= 3);
    CHECK(face.normal.norm() == Approx(1));
    for (const Vec3& point : points) CHECK(face.normal.dot(point) <= face.offset + tolerance);
  }
}

std::vector<Vec3> grid(int count, const Vec3& half) {
  std::vector<Vec3> points;
  for (int x = 0; x < count; ++x) {
    for (int y = 0; y < count; ++y) {
      for (int z = 0; z < count; ++z) {
        points.push_back(half.cwiseProduct(Vec3(x, y, z) * 2 / (count - 1) - Vec3::Ones()));
      }
    }
  }
  return points;
}

TEST_CASE("The hull of a grid has eight corners, at any pose and in single precision", "[math]") {
  const Mat3 turn = Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized()).toRotationMatrix();
  std::vector<Vec3> points = grid(6, {0.03, 0.02, 0.04});
  for (Vec3& point : points) {
    point = (turn * point + Vec3(0.1, 0, 0.2)).cast<float>().cast<double>().eval();
  }
  const ConvexHull hull = convex_hull(points);
  CHECK(hull.corners.size() == 8);
  CHECK(hull.faces.size() == 6);
  CHECK(hull.edges.size() == 12);
  check_sound(hull, points, 1e-7);
  const HullMoments moments = moments_of(hull);
  CHECK(moments.volume == Approx(8 * 0.03 * 0.02 * 0.04));
  CHECK((moments.first / moments.volume).isApprox(Vec3(0.1, 0, 0.2), 1e-6));
}

TEST_CASE("A hull of box_hull is that of its corners", "[math]") {
  const Vec3 half(0.1, 0.2, 0.3);
  const ConvexHull box = box_hull(half);
  check_sound(box, box.corners, 1e-12);
  const ConvexHull found = convex_hull(box.corners);
  CHECK(found.faces.size() == box.faces.size());
  CHECK(moments_of(box).volume == Approx(moments_of(found).volume));
  CHECK(moments_of(box).second(0, 0) == Approx(8 * half.prod() * half.x() * half.x() / 3));
  CHECK(moments_of(box).second(0, 1) == Approx(0).margin(1e-12));
}

TEST_CASE("A cylinder's caps are one face each", "[math]") {
  std::vector<Vec3> points;
  for (int i = 0; i < 24; ++i) {
    const double angle = 2 * std::numbers::pi * i / 24;
    for (const double z : {0.0, 0.05}) {
      points.emplace_back(0.02 * std::cos(angle), 0.02 * std::sin(angle), z);
    }
  }
  const ConvexHull hull = convex_hull(points);
  CHECK(hull.corners.size() == 48);
  CHECK(hull.faces.size() == 26);
  check_sound(hull, points, 1e-9);
}

TEST_CASE("Round meshes keep 64 corners that enclose nearly all of them", "[math]") {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  std::vector<Vec3> points;
  for (int i = 0; i < 3000; ++i) {
    points.push_back(0.05 * Vec3(normal(random), normal(random), normal(random)).normalized());
  }
  const ConvexHull hull = convex_hull(points);
  CHECK(hull.corners.size() == ConvexHull::kMaxCorners);
  check_sound(hull, points, 0.12 * 0.05);
  const double ball = 4.0 / 3 * std::numbers::pi * std::pow(0.05, 3);
  CHECK(moments_of(hull).volume > 0.85 * ball);
}

TEST_CASE("Hulls of random points are sound", "[math]") {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (int round = 0; round < 40; ++round) {
    std::vector<Vec3> points;
    const int count = 4 + static_cast<int>(random() % 60);
    const double thickness = round % 2 == 0 ? 1 : 0.05;
    for (int i = 0; i < count; ++i) {
      points.emplace_back(uniform(random), uniform(random), thickness * uniform(random));
      // Many in one plane, and some twice.
      if (i % 3 == 0) points.back().z() = -thickness;
      if (i % 7 == 0) points.push_back(points.front());
    }
    CAPTURE(round);
    check_sound(convex_hull(points), points, 3e-4);
  }
}

TEST_CASE("Points without a volume are refused", "[math]") {
  CHECK_THROWS_WITH(convex_hull(std::vector<Vec3>(3, Vec3::Zero())), "3 points given, 4 needed");
  CHECK_THROWS_WITH(convex_hull(grid(4, {0.1, 0.1, 0})), Catch::Contains("flat"));
  CHECK_THROWS_WITH(convex_hull(grid(4, {0.1, 0, 0})), Catch::Contains("flat"));
  CHECK_THROWS_WITH(convex_hull(grid(4, {0, 0, 0})), Catch::Contains("flat"));
}

}  // namespace
}  // namespace engram
