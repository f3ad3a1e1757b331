// The shapes that the red cube traces: 64 waypoints, every fifth of which is a checkpoint.
#pragma once

#include "tasks/parts/layout.h"

namespace engram::tasks {

inline constexpr int NUM_WAYPOINTS = 64;
inline constexpr int NUM_CHECKPOINTS = 12;
inline constexpr double CHECKPOINT_THRESH = 0.035;  // m

inline constexpr int SHAPE_CIRCLE = 0;
inline constexpr int SHAPE_SQUARE = 1;
inline constexpr int SHAPE_TRIANGLE = 2;
inline constexpr int kContourShapes = 3;

// "circle", "square" or "triangle".
const char* contour_name(int shape);

class Contour {
 public:
  // radius: of the circle, half a side of the square, or from the triangle's centre to its corners;
  // m. rotation: rad, counter-clockwise.
  Contour(int shape, double radius, double rotation, const Vec2& center);

  int shape() const { return shape_; }
  const Vec2& center() const { return center_; }
  // index 0, ..., NUM_WAYPOINTS - 1.
  Vec2 waypoint(int index) const;
  // index 0, ..., NUM_CHECKPOINTS - 1. The last waypoints have none.
  Vec2 checkpoint(int index) const { return waypoint(index * (NUM_WAYPOINTS / NUM_CHECKPOINTS)); }

 private:
  int shape_;
  Vec2 center_;
  Vec2 x_axis_;  // of the shape, as long as its radius
};

// Visited checkpoints are bits of a number, checkpoint 0 the lowest.
inline constexpr int kAllVisited = (1 << NUM_CHECKPOINTS) - 1;

// `visited`, and those that are near `at`.
int visit(const Contour& contour, const Vec2& at, int visited);
int count_visits(int visited);
double visited_fraction(int visited);  // of the checkpoints
// Whether all have been visited and `at` is back at the first.
bool is_closed(const Contour& contour, const Vec2& at, int visited);
// The lowest that has not been visited; the first again once all have.
int next_checkpoint(int visited);
// The one nearest to `at` of those that have not been visited; of all once none is left.
int nearest_checkpoint(const Contour& contour, const Vec2& at, int visited);

}  // namespace engram::tasks
