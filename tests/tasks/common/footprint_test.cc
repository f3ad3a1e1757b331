#include "tasks/common/footprint.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "core/math/random.h"
#include "mjcf/object_shapes.h"
#include "tasks/common/overlap_guard.h"

namespace engram::tasks {
namespace {

using mjcf::ObjectShape;

FootprintPart rectangle(double half_x, double half_y, double yaw = 0, const Vec2& center = {0, 0}) {
  return {center, {half_x, half_y}, std::cos(yaw), std::sin(yaw), 0};
}

FootprintPart disc(double radius) { return {{0, 0}, {0, 0}, 1, 0, radius}; }

Footprint footprint(ObjectShape shape) { return footprint_of(mjcf::shape_prop("prop", shape, {})); }

TEST_CASE("Gaps between discs and rectangles are exact", "[footprint]") {
  constexpr double kEighth = std::numbers::pi / 4;
  CHECK(part_clearance(disc(1), disc(2), {3, 4}) == Approx(2));
  CHECK(part_clearance(disc(1), disc(2), {0, 2}) == Approx(-1));
  CHECK(part_clearance(rectangle(2, 1), disc(0.5), {3, 0.5}) == Approx(0.5));
  CHECK(part_clearance(rectangle(2, 1), disc(0.5), {5, 5}) == Approx(4.5));
  CHECK(part_clearance(disc(0.5), rectangle(2, 1), {0, 1.2}) == Approx(-0.3));
  CHECK(part_clearance(rectangle(2, 1), disc(0.5), {0, 0.8}) == Approx(-0.7));
  CHECK(part_clearance(rectangle(2, 1), rectangle(1, 1), {4, 2.5}) == Approx(std::hypot(1, 0.5)));
  // A corner points at a side.
  CHECK(part_clearance(rectangle(1, 1), rectangle(1, 1, kEighth), {3, 0}) ==
        Approx(2 - std::sqrt(2)));
  CHECK(part_clearance(rectangle(1, 1, kEighth), rectangle(1, 1), {0, 2}) ==
        Approx(1 - std::sqrt(2)));
  // The part's own place counts.
  CHECK(part_clearance(rectangle(1, 1, 0, {1, 0}), disc(1), {4, 0}) == Approx(1));
}

TEST_CASE("Squares have the clearance of squares", "[footprint]") {
  const Footprint cube = footprint(ObjectShape::kCube);
  RandomStream random(1, 0, 0);
  for (int i = 0; i < 1000; ++i) {
    const double x = random.uniform(-0.06, 0.06);
    const Vec2 offset(x, random.uniform(-0.06, 0.06));
    const double expected = square_clearance(0.02, offset);
    const double found = clearance(cube, cube, offset);
    if (expected < kMinClearance) CHECK(found == Approx(expected).margin(1e-12));
    CHECK((found >= kMinClearance) == (expected >= kMinClearance));
    CHECK(found <= expected + 1e-12);
  }
}

// Points on the outline of a part, in the frame of its prop.
template <class Visit>
void outline(const FootprintPart& part, const Visit& visit) {
  constexpr int kPoints = 400;
  for (int i = 0; i < kPoints; ++i) {
    const double angle = 2 * std::numbers::pi * i / kPoints;
    Vec2 point = part.radius * Vec2(std::cos(angle), std::sin(angle));
    if (part.half.x() > 0) {  // once around the rectangle
      const double s = std::fmod(4.0 * i / kPoints, 1.0) * 2 - 1;
      const Vec2 sides[] = {{1, s}, {-s, 1}, {-1, -s}, {s, -1}};
      point = sides[4 * i / kPoints].cwiseProduct(part.half);
    }
    visit(Vec2(part.center + Vec2(part.cosine * point.x() - part.sine * point.y(),
                                  part.sine * point.x() + part.cosine * point.y())));
  }
}

TEST_CASE("Gaps between shapes are those between their outlines", "[footprint]") {
  RandomStream random(2, 0, 0);
  int compared = 0;
  for (int i = 0; i < mjcf::kObjectShapeCount; ++i) {
    for (int j = 0; j < mjcf::kObjectShapeCount; ++j) {
      const Footprint a = footprint(static_cast<ObjectShape>(i));
      const Footprint b = footprint(static_cast<ObjectShape>(j));
      for (int round = 0; round < 3; ++round) {
        const double angle = random.uniform(0, 2 * std::numbers::pi);
        const Vec2 direction(std::cos(angle), std::sin(angle));
        // Out to where they just do not touch.
        double distance = 0;
        while (clearance(a, b, distance * direction) <= 2e-4) distance += 1e-4;
        const Vec2 offset = distance * direction;
        double least = 1;
        for (const FootprintPart& first : a.parts) {
          for (const FootprintPart& second : b.parts) {
            if (part_clearance(first, second, offset) > 1e-3) continue;
            outline(first, [&](const Vec2& p) {
              outline(second,
                      [&](const Vec2& q) { least = std::min(least, (offset + q - p).norm()); });
            });
          }
        }
        INFO(i << " and " << j << " at " << offset.transpose());
        CHECK(least == Approx(clearance(a, b, offset)).margin(2e-4));
        CHECK(clearance(b, a, -offset) == Approx(clearance(a, b, offset)).margin(1e-9));
        ++compared;
      }
    }
  }
  CHECK(compared == 243);
}

TEST_CASE("A t_shape reaches into its neighbours on one side only", "[footprint]") {
  // 60 mm between origins are not enough on the side of the bar.
  const Footprint t_shape = footprint(ObjectShape::kTShape);
  for (const ObjectShape other : {ObjectShape::kCross, ObjectShape::kStar, ObjectShape::kTorus}) {
    double least = 1;
    for (double angle = 0; angle < std::numbers::pi; angle += 0.02) {
      const Vec2 offset = 0.06 * Vec2(std::cos(angle), std::sin(angle));
      least = std::min(least, clearance(t_shape, footprint(other), offset));
      CHECK(clearance(t_shape, footprint(other), -offset) > 0);
    }
    CHECK(least < 0);
    CHECK(least > -0.015);  // no part is wider
  }
  CHECK(clearance(t_shape, footprint(ObjectShape::kCross), {0, 0.06}) == Approx(-0.01));
}

TEST_CASE("A prop that lies on an edge has no footprint", "[footprint]") {
  mjcf::Prop prop = mjcf::cube("tilted", 0.02, {});
  CHECK(footprint_of(prop).parts.size() == 1);
  prop.quat = {std::cos(0.2), std::sin(0.2), 0, 0};
  CHECK_THROWS_WITH(footprint_of(prop), Catch::Contains("'tilted'"));
  prop.quat = {std::sqrt(0.5), std::sqrt(0.5), 0, 0};  // on another face
  prop.primitives[0].size = {0.01, 0.02, 0.03};
  const FootprintPart part = footprint_of(prop).parts[0];
  CHECK(part_clearance(part, disc(0.01), {0.03, 0}) == Approx(0.01));
  CHECK(part_clearance(part, disc(0.01), {0, 0.05}) == Approx(0.01));
}

}  // namespace
}  // namespace engram::tasks
