#include "tasks/trace_shape/contour.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>

#include "core/math/real_functions.h"

namespace engram::tasks {
namespace {

Vec2 on_circle(double turns) {
  const double angle = 2 * std::numbers::pi * turns;
  return {real::cos(angle), real::sin(angle)};
}

// part: of the way around, 0 <= part < 1.
Vec2 square_point(double part) {
  const double side = std::floor(4 * part);
  const double along = 2 * (4 * part - side) - 1;
  switch (static_cast<int>(side)) {
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

// Sides of 22, 21 and 21 of 64 waypoints; only the first corner is one.
Vec2 triangle_point(int index, int waypoints) {
  const double sides = 3.0 * index / waypoints;
  const double side = std::floor(sides);
  const Vec2 from = on_circle(side / 3);
  return from + (sides - side) * (on_circle((side + 1) / 3) - from);
}

}  // namespace

ContourSet::ContourSet(const ContourParams& params)
    : params_(params), stride_(params.NUM_WAYPOINTS / params.NUM_CHECKPOINTS) {
  const int count = waypoints();
  for (int i = 0; i < count; ++i) points_.push_back(on_circle(static_cast<double>(i) / count));
  for (int i = 0; i < count; ++i) points_.push_back(square_point(static_cast<double>(i) / count));
  for (int i = 0; i < count; ++i) points_.push_back(triangle_point(i, count));
}

double ContourSet::visited_fraction(int visited) const {
  return static_cast<double>(count_visits(visited)) / checkpoints();
}

int ContourSet::next_checkpoint(int visited) const {
  return visited == all_visited() ? 0 : std::countr_one(static_cast<unsigned>(visited));
}

int count_visits(int visited) { return std::popcount(static_cast<unsigned>(visited)); }

double farthest_point(int shape) { return shape == SHAPE_SQUARE ? std::numbers::sqrt2 : 1; }

double nearest_point(int shape) { return shape == SHAPE_TRIANGLE ? 0.5 : 1; }

Contour::Contour(const ContourSet& set, int shape, double radius, double rotation,
                 const Vec2& center)
    : set_(&set),
      shape_(shape),
      center_(center),
      x_axis_(radius * real::cos(rotation), radius * real::sin(rotation)) {}

Vec2 Contour::waypoint(int index) const {
  const Vec2& unit = set_->waypoint(shape_, index);
  return {center_.x() + unit.x() * x_axis_.x() - unit.y() * x_axis_.y(),
          center_.y() + unit.x() * x_axis_.y() + unit.y() * x_axis_.x()};
}

int visit(const Contour& contour, const Vec2& at, int visited) {
  const ContourSet& set = contour.set();
  for (int i = 0; i < set.checkpoints(); ++i) {
    const bool near = (contour.checkpoint(i) - at).norm() < set.reach();
    visited |= static_cast<int>(near) << i;
  }
  return visited;
}

bool is_closed(const Contour& contour, const Vec2& at, int visited) {
  const ContourSet& set = contour.set();
  return visited == set.all_visited() && (contour.checkpoint(0) - at).norm() < set.reach();
}

int nearest_checkpoint(const Contour& contour, const Vec2& at, int visited) {
  const ContourSet& set = contour.set();
  int nearest = -1;
  double least = 0;
  for (int i = 0; i < set.checkpoints(); ++i) {
    if (visited != set.all_visited() && (visited >> i & 1) != 0) continue;
    const double distance = (contour.checkpoint(i) - at).norm();
    if (nearest >= 0 && distance >= least) continue;
    nearest = i;
    least = distance;
  }
  return nearest;
}

// A waypoint ahead of the one where `at` is between the last checkpoints and the next one; the
// farther it has strayed from the contour, the nearer.
Vec2 lookahead_point(const Contour& contour, int visited, const Vec2& at) {
  constexpr double kAhead = 0.035;   // m along the contour
  constexpr double kStrayed = 0.02;  // m: from there on, back to the contour first
  const ContourSet& set = contour.set();
  const int next = set.next_checkpoint(visited);
  if (visited == 0) return contour.checkpoint(next);
  const int last = next > 0 ? set.waypoint_of(next) : set.waypoints();
  const auto waypoint = [&](int index) { return contour.waypoint(index % set.waypoints()); };
  const auto away = [&](int index) { return (waypoint(index) - at).norm(); };
  int target = last;
  for (int i = std::max(0, last - 2 * set.waypoint_of(1)); i < last; ++i) {
    if (away(i) < away(target)) target = i;
  }
  double ahead = kAhead * (1 - away(target) / kStrayed);
  for (; target < last && ahead > 0; ++target) {
    ahead -= (waypoint(target + 1) - waypoint(target)).norm();
  }
  return waypoint(target);
}

}  // namespace engram::tasks
