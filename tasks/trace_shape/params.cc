#include "tasks/trace_shape/params.h"

#include <algorithm>
#include <string>

#include "core/base/join.h"

namespace engram::tasks {
namespace {

constexpr int kTimeToTake = 20;    // control steps: to take the green cube
constexpr int kTimeToTrace = 30;   // a shape
constexpr double kFarthest = 0.2;  // m, of a corner: what is left in front of the lamp

void require(bool holds, const char* name, const std::string& given, const std::string& allowed) {
  if (!holds) refuse_constant(name, given, allowed + " allowed");
}

}  // namespace

void TraceParams::constants(Changes& list) {
  list.names("AVAILABLE_SHAPES", AVAILABLE_SHAPES, kContourNames, 1,
             "shapes that a demonstration is drawn from");
  list.integer("NUM_WAYPOINTS", contours.NUM_WAYPOINTS, {24, 500}, "",
               "control steps in which the red cube traces a shape");
  list.integer("NUM_CHECKPOINTS", contours.NUM_CHECKPOINTS, {3, ContourSet::kMostCheckpoints}, "",
               "points of a shape that are checked");
  list.real("CHECKPOINT_THRESH", contours.CHECKPOINT_THRESH, {0.01, 0.08}, "m",
            "how near the green cube has to come to them");
  list.real_range(
      "SHAPE_RADIUS_RANGE", SHAPE_RADIUS_RANGE[0], SHAPE_RADIUS_RANGE[1], {0.04, kFarthest}, "m",
      "radius of the circle, half a side of the square, or from the triangle's centre to "
      "its corners");
  if (sequence) {
    constexpr Bounds kLength{1, 6};
    list.integer("MIN_SEQUENCE_LENGTH", MIN_SEQUENCE_LENGTH, kLength, "",
                 "least number of shapes in a sequence");
    list.integer("MAX_SEQUENCE_LENGTH", MAX_SEQUENCE_LENGTH, kLength, "",
                 "greatest number of shapes in a sequence");
  }
  smoothness.constants(list);
}

void TraceParams::check(int horizon) const {
  const int checkpoints = contours.NUM_CHECKPOINTS;
  require(checkpoints <= contours.NUM_WAYPOINTS, "NUM_CHECKPOINTS", std::to_string(checkpoints),
          "at most NUM_WAYPOINTS " + std::to_string(contours.NUM_WAYPOINTS));
  require(MIN_SEQUENCE_LENGTH <= MAX_SEQUENCE_LENGTH, "MIN_SEQUENCE_LENGTH",
          std::to_string(MIN_SEQUENCE_LENGTH),
          "at most MAX_SEQUENCE_LENGTH " + std::to_string(MAX_SEQUENCE_LENGTH));
  const double radius = SHAPE_RADIUS_RANGE[1];
  const double corner = farthest_corner();
  require(corner <= kFarthest, "SHAPE_RADIUS_RANGE", shortest(radius),
          "with corners " + shortest(corner) + " m from the centre, at most " +
              shortest(radius * kFarthest / corner) + " for corners within " + shortest(kFarthest) +
              " m");
  const std::string demo = std::to_string(MAX_SEQUENCE_LENGTH) + " x NUM_WAYPOINTS " +
                           std::to_string(contours.NUM_WAYPOINTS) + " =";
  check_time(horizon,
             {{"PRE_DEMO_STEPS", PRE_DEMO_STEPS.high},
              {demo.c_str(), MAX_SEQUENCE_LENGTH * contours.NUM_WAYPOINTS}},
             kTimeToTake + MAX_SEQUENCE_LENGTH * kTimeToTrace);
}

double TraceParams::farthest_corner() const {
  double farthest = 0;
  for (int i = 0; i < AVAILABLE_SHAPES.size(); ++i) {
    farthest = std::max(farthest, farthest_point(AVAILABLE_SHAPES[i]));
  }
  return farthest * SHAPE_RADIUS_RANGE[1];
}

double TraceParams::nearest_point() const {
  double nearest = 1;
  for (int i = 0; i < AVAILABLE_SHAPES.size(); ++i) {
    nearest = std::min(nearest, tasks::nearest_point(AVAILABLE_SHAPES[i]));
  }
  return nearest * SHAPE_RADIUS_RANGE[0];
}

}  // namespace engram::tasks
