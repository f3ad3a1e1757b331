// Waypoints and checkpoints of the contours in worked examples.
#include "tasks/trace_shape/contour.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

namespace engram::tasks {
namespace {

struct Example {
  int shape;
  int waypoint;
  double x;
  double y;
};

const ContourSet kShapes;

TEST_CASE("Waypoints are those of the worked examples", "[contour]") {
  constexpr Example kExamples[] = {
      {SHAPE_CIRCLE, 0, -0.00447, 0.07955},    {SHAPE_CIRCLE, 16, -0.12955, 0.14553},
      {SHAPE_CIRCLE, 55, -0.01655, -0.00510},  {SHAPE_CIRCLE, 63, -0.00203, 0.07005},
      {SHAPE_SQUARE, 0, -0.16598, -0.07509},   {SHAPE_SQUARE, 16, 0.02509, -0.01598},
      {SHAPE_SQUARE, 20, 0.01031, 0.03179},    {SHAPE_SQUARE, 55, -0.19923, 0.03239},
      {SHAPE_SQUARE, 63, -0.16968, -0.06314},  {SHAPE_TRIANGLE, 0, -0.00447, 0.07955},
      {SHAPE_TRIANGLE, 22, -0.17176, 0.11279}, {SHAPE_TRIANGLE, 43, -0.12033, -0.04553},
      {SHAPE_TRIANGLE, 55, -0.05412, 0.02595}, {SHAPE_TRIANGLE, 63, -0.00998, 0.07360},
  };
  for (const Example& example : kExamples) {
    const Contour contour(kShapes, example.shape, 0.10, 0.3, {-0.10, 0.05});
    const Vec2 point = contour.waypoint(example.waypoint);
    INFO(kContourNames[static_cast<std::size_t>(example.shape)] << " " << example.waypoint);
    CHECK(point.x() == Approx(example.x).margin(6e-6));
    CHECK(point.y() == Approx(example.y).margin(6e-6));
  }
}

TEST_CASE("Shapes step as far as the spec says", "[contour]") {
  constexpr double kStep[] = {0.098, 0.125, 0.081};  // of the radius
  for (int shape = 0; shape < kContourShapes; ++shape) {
    const Contour contour(kShapes, shape, 0.1, 1, {0, 0});
    for (int i = 1; i < kShapes.waypoints(); ++i) {
      const double step = (contour.waypoint(i) - contour.waypoint(i - 1)).norm() / 0.1;
      // Corners of the triangle lie between waypoints and are cut.
      CHECK(step < kStep[shape] + 6e-4);
      CHECK(step > 0.5 * kStep[shape]);
    }
  }
}

TEST_CASE("Every fifth waypoint up to 55 is a checkpoint", "[contour]") {
  const Contour contour(kShapes, SHAPE_SQUARE, 0.1, 0.7, {0.1, -0.1});
  for (int i = 0; i < kShapes.checkpoints(); ++i) {
    CHECK(contour.checkpoint(i) == contour.waypoint(5 * i));
  }
  CHECK(kShapes.checkpoints() == 12);
}

TEST_CASE("Checkpoints are visited within 35 mm, in any order, for good", "[contour]") {
  const Contour contour(kShapes, SHAPE_CIRCLE, 0.13, 0, {0, 0});
  int visited = visit(contour, {0, 0}, 0);
  CHECK(visited == 0);
  visited = visit(contour, contour.checkpoint(7) + Vec2(0.0349, 0), visited);
  CHECK((visited >> 7 & 1) == 1);
  CHECK((visit(contour, contour.checkpoint(3) + Vec2(0, 0.0351), 0) >> 3 & 1) == 0);
  CHECK(visit(contour, {0, 0}, visited) == visited);
  CHECK(kShapes.next_checkpoint(visited) == 0);
  CHECK(kShapes.next_checkpoint(0b1011) == 2);
  CHECK(kShapes.next_checkpoint(kShapes.all_visited()) == 0);
  CHECK(nearest_checkpoint(contour, contour.checkpoint(7), 1 << 7) != 7);
  CHECK(nearest_checkpoint(contour, contour.checkpoint(7), kShapes.all_visited()) == 7);
  for (int i = 0; i < kShapes.checkpoints(); ++i)
    visited = visit(contour, contour.checkpoint(i), visited);
  CHECK(visited == kShapes.all_visited());
  CHECK(count_visits(visited) == 12);
  // Closed only near the first.
  CHECK_FALSE(is_closed(contour, contour.checkpoint(11), visited));
  CHECK(is_closed(contour, contour.checkpoint(0) + Vec2(0.034, 0), visited));
  CHECK_FALSE(is_closed(contour, contour.checkpoint(0), visited & ~(1 << 4)));
}

TEST_CASE("One place visits several checkpoints of a small shape", "[contour]") {
  const Contour contour(kShapes, SHAPE_CIRCLE, 0.078, 0, {0, 0});
  const Vec2 between = (contour.waypoint(2) + contour.waypoint(3)) / 2;
  CHECK(count_visits(visit(contour, between, 0)) == 2);
}

TEST_CASE("A pursuit begins at the first checkpoint and looks ahead from there", "[contour]") {
  const Contour contour(kShapes, SHAPE_CIRCLE, 0.1, 0, {0, 0});
  CHECK(lookahead_point(contour, 0, {0.5, 0.5}) == contour.checkpoint(0));
  // On the contour: 35 mm ahead, which is four waypoints, but not beyond the next checkpoint.
  CHECK(lookahead_point(contour, 1, contour.waypoint(0)) == contour.waypoint(4));
  CHECK(lookahead_point(contour, 1, contour.waypoint(3)) == contour.checkpoint(1));
  // Astray: back to the nearest waypoint first.
  const Vec2 astray = 1.5 * contour.waypoint(2);
  CHECK(lookahead_point(contour, 1, astray) == contour.waypoint(2));
  // All visited: back to the start.
  const int all = kShapes.all_visited();
  CHECK(lookahead_point(contour, all, contour.waypoint(63)) == contour.waypoint(0));
}

}  // namespace
}  // namespace engram::tasks
