#include "tasks/trace_shape/contour.h"

#include <array>
#include <bit>
#include <cmath>
#include <numbers>

#include "core/base/real_functions.h"

namespace engram::tasks {
namespace {

using Shape = std::array<Vec2, NUM_WAYPOINTS>;

Vec2 on_circle(double turns) {
  const double angle = 2 * std::numbers::pi * turns;
  return {real::cos(angle), real::sin(angle)};
}

Vec2 circle_point(int index) { return on_circle(static_cast<double>(index) / NUM_WAYPOINTS); }

Vec2 square_point(int index) {
  constexpr int kPerSide = NUM_WAYPOINTS / 4;
  const double along = 2.0 * (index % kPerSide) / kPerSide - 1;
  switch (index / kPerSide) {
    case 0:
      return {along, -1};
    case 1:
      return {1, along};
    case 2:
      return {-along, 1};
    default:
      return {-1, -along};
  }
}

// The sides take 22, 21 and 21 waypoints; only the first corner is one.
Vec2 triangle_point(int index) {
  const double sides = 3.0 * index / NUM_WAYPOINTS;
  const double side = std::floor(sides);
  const Vec2 from = on_circle(side / 3);
  return from + (sides - side) * (on_circle((side + 1) / 3) - from);
}

std::array<Shape, kContourShapes> make_unit_shapes() {
  std::array<Shape, kContourShapes> shapes;
  for (int i = 0; i < NUM_WAYPOINTS; ++i) {
    const auto at = static_cast<std::size_t>(i);
    shapes[SHAPE_CIRCLE][at] = circle_point(i);
    shapes[SHAPE_SQUARE][at] = square_point(i);
    shapes[SHAPE_TRIANGLE][at] = triangle_point(i);
  }
  return shapes;
}

// A waypoint of a shape with radius 1, unturned, about the origin.
const Vec2& unit_waypoint(int shape, int index) {
  static const std::array<Shape, kContourShapes> shapes = make_unit_shapes();
  return shapes[static_cast<std::size_t>(shape)][static_cast<std::size_t>(index)];
}

}  // namespace

const char* contour_name(int shape) {
  static constexpr std::array<const char*, kContourShapes> kNames = {"circle", "square",
                                                                     "triangle"};
  return kNames[static_cast<std::size_t>(shape)];
}

Contour::Contour(int shape, double radius, double rotation, const Vec2& center)
    : shape_(shape),
      center_(center),
      x_axis_(radius * real::cos(rotation), radius * real::sin(rotation)) {}

Vec2 Contour::waypoint(int index) const {
  const Vec2& unit = unit_waypoint(shape_, index);
  return {center_.x() + unit.x() * x_axis_.x() - unit.y() * x_axis_.y(),
          center_.y() + unit.x() * x_axis_.y() + unit.y() * x_axis_.x()};
}

int visit(const Contour& contour, const Vec2& at, int visited) {
  for (int i = 0; i < NUM_CHECKPOINTS; ++i) {
    const bool near = (contour.checkpoint(i) - at).norm() < CHECKPOINT_THRESH;
    visited |= static_cast<int>(near) << i;
  }
  return visited;
}

int count_visits(int visited) { return std::popcount(static_cast<unsigned>(visited)); }

double visited_fraction(int visited) {
  return static_cast<double>(count_visits(visited)) / NUM_CHECKPOINTS;
}

bool is_closed(const Contour& contour, const Vec2& at, int visited) {
  return visited == kAllVisited && (contour.checkpoint(0) - at).norm() < CHECKPOINT_THRESH;
}

int next_checkpoint(int visited) {
  return visited == kAllVisited ? 0 : std::countr_one(static_cast<unsigned>(visited));
}

int nearest_checkpoint(const Contour& contour, const Vec2& at, int visited) {
  int nearest = -1;
  double least = 0;
  for (int i = 0; i < NUM_CHECKPOINTS; ++i) {
    if (visited != kAllVisited && (visited >> i & 1) != 0) continue;
    const double distance = (contour.checkpoint(i) - at).norm();
    if (nearest >= 0 && distance >= least) continue;
    nearest = i;
    least = distance;
  }
  return nearest;
}

}  // namespace engram::tasks
