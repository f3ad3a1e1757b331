// The shapes that the red cube traces: waypoints, some of which are checkpoints.
#pragma once

#include <array>
#include <vector>

#include "core/base/index.h"
#include "tasks/common/layout.h"

namespace engram::tasks {

inline constexpr int SHAPE_CIRCLE = 0;
inline constexpr int SHAPE_SQUARE = 1;
inline constexpr int SHAPE_TRIANGLE = 2;
inline constexpr int kContourShapes = 3;
inline constexpr std::array<const char*, kContourShapes> kContourNames = {"circle", "square",
                                                                          "triangle"};

// Division of contours. Named as the class constants.
struct ContourParams {
  int NUM_WAYPOINTS = 64;
  int NUM_CHECKPOINTS = 12;
  double CHECKPOINT_THRESH = 0.035;  // m

  friend bool operator==(const ContourParams&, const ContourParams&) = default;
};

// The shapes with radius 1, unturned, about the origin. Visited checkpoints are bits of a number,
// checkpoint 0 the lowest.
class ContourSet {
 public:
  static constexpr int kMaxCheckpoints = 30;

  explicit ContourSet(const ContourParams& params = {});

  int waypoints() const { return params_.NUM_WAYPOINTS; }
  int checkpoints() const { return params_.NUM_CHECKPOINTS; }
  double reach() const { return params_.CHECKPOINT_THRESH; }
  const Vec2& waypoint(int shape, int index) const {
    return points_[at(shape * waypoints() + index)];
  }
  // The waypoint that is a checkpoint. The last waypoints are none.
  int waypoint_of(int checkpoint) const { return checkpoint * stride_; }

  int all_visited() const { return (1 << checkpoints()) - 1; }
  double visited_fraction(int visited) const;  // of the checkpoints
  // The lowest that has not been visited; the first again once all have.
  int next_checkpoint(int visited) const;

 private:
  ContourParams params_;
  int stride_;                // waypoints from checkpoint to checkpoint
  std::vector<Vec2> points_;  // shape by shape
};

int count_visits(int visited);

// One of these shapes on the table.
class Contour {
 public:
  // radius: of the circle, half a side of the square, or from the triangle's centre to its corners;
  // m. rotation: rad, counter-clockwise. The set has to outlive the contour.
  Contour(const ContourSet& set, int shape, double radius, double rotation, const Vec2& center);

  const ContourSet& set() const { return *set_; }
  int shape() const { return shape_; }
  const Vec2& center() const { return center_; }
  // Another shape with the same place, size and turn.
  Contour as(int shape) const {
    Contour other = *this;
    other.shape_ = shape;
    return other;
  }
  // index 0, ..., NUM_WAYPOINTS - 1.
  Vec2 waypoint(int index) const;
  // index 0, ..., NUM_CHECKPOINTS - 1.
  Vec2 checkpoint(int index) const { return waypoint(set_->waypoint_of(index)); }

 private:
  const ContourSet* set_;
  int shape_;
  Vec2 center_;
  Vec2 x_axis_;  // of the shape, as long as its radius
};

// Distances from the centre of a shape with radius 1 to its farthest points, and to its nearest
// ones.
double farthest_point(int shape);
double nearest_point(int shape);

// `visited`, and those that are near `at`.
int visit(const Contour& contour, const Vec2& at, int visited);
// True if all have been visited and `at` is back at the first.
bool is_closed(const Contour& contour, const Vec2& at, int visited);
// Pure pursuit: the point to steer for from `at`, ahead on the contour towards the first
// checkpoint that was not visited, or back to the start.
Vec2 lookahead_point(const Contour& contour, int visited, const Vec2& at);
// Nearest to `at` of those that have not been visited; of all once none is left.
int nearest_checkpoint(const Contour& contour, const Vec2& at, int visited);

}  // namespace engram::tasks
