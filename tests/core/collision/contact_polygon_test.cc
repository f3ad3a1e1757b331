#include "core/collision/contact_polygon.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

namespace engram {
namespace {

ContactPolygon square(double half) {
  ContactPolygon polygon;
  for (const auto& [x, y] : {std::array{1, 1}, {1, -1}, {-1, -1}, {-1, 1}}) {
    polygon.push({x * half, y * half, 0.1 * x});
  }
  return polygon;
}

double area(const ContactPolygon& polygon) {
  double twice = 0;
  for (int i = 0; i < polygon.size(); ++i) {
    const Vec3& a = polygon[i];
    const Vec3& b = polygon[(i + 1) % polygon.size()];
    twice += a.x() * b.y() - a.y() * b.x();
  }
  return std::abs(twice) / 2;
}

TEST_CASE("Clipping keeps one side of a line and interpolates the gap", "[contact]") {
  ContactPolygon polygon = square(1);
  polygon.clip(1, 0, 0.5);  // x <= 0.5
  REQUIRE(polygon.size() == 4);
  CHECK(area(polygon) == Approx(3));
  for (int i = 0; i < 4; ++i) {
    CHECK(polygon[i].x() <= 0.5 + 1e-12);
    CHECK(polygon[i].z() == Approx(0.1 * polygon[i].x()));
  }
  const double diagonal = 1 / std::numbers::sqrt2;
  polygon.clip(-diagonal, -diagonal, 0);  // x + y >= 0
  CHECK(area(polygon) == Approx(1.125));
}

TEST_CASE("Clipping keeps all or nothing of what lies on one side", "[contact]") {
  ContactPolygon polygon = square(1);
  polygon.clip(0, 1, 2);
  CHECK(polygon.size() == 4);
  polygon.clip(0, 1, 1);  // a side on the line
  CHECK(polygon.size() == 4);
  polygon.clip(0, 1, -2);
  CHECK(polygon.size() == 0);
  polygon.clip(1, 0, 0);
  CHECK(polygon.size() == 0);
}

TEST_CASE("Four points are left: the deepest, the farthest, one on each side", "[contact]") {
  ContactPolygon polygon;
  for (int i = 0; i < 12; ++i) {
    const double angle = 2 * std::numbers::pi * i / 12;
    polygon.push({std::cos(angle), std::sin(angle), i == 5 ? -0.01 : 0.0});
  }
  const Vec3 deepest = polygon[5];
  polygon.reduce_to_four();
  REQUIRE(polygon.size() == 4);
  CHECK(polygon[0] == deepest);
  CHECK((polygon[1] - deepest).head<2>().norm() == Approx(2));
  const Vec3 middle = (polygon[2] + polygon[3]) / 2;
  CHECK(middle.head<2>().norm() == Approx(0).margin(1e-9));
  CHECK((polygon[2] - polygon[3]).head<2>().norm() == Approx(2));
}

TEST_CASE("Up to four points stay as they are, and points on a line become two", "[contact]") {
  ContactPolygon polygon = square(1);
  polygon.reduce_to_four();
  CHECK(polygon.size() == 4);
  ContactPolygon line;
  for (int i = 0; i < 6; ++i) line.push({0.1 * i, 0, 0});
  line.reduce_to_four();
  REQUIRE(line.size() == 2);
  CHECK((line[0] - line[1]).norm() == Approx(0.5));
}

}  // namespace
}  // namespace engram
