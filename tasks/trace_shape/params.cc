#include "tasks/trace_shape/params.h"

#include <algorithm>
#include <string>

#include "core/base/join.h"
#include "tasks/common/lamp.h"
#include "tasks/common/phase_budget.h"
#include "tasks/trace_shape/rewards.h"

namespace engram::tasks {
namespace {

constexpr int kTimeToTake = 20;    // control steps: to take the green cube
constexpr int kTimeToTrace = 30;   // a shape
constexpr double kFarthest = 0.2;  // m, of a corner: what is left in front of the lamp

Constant ids_of(const NameList& shapes) {
  ConstantList ids;
  for (int i = 0; i < shapes.size(); ++i) ids.emplace_back(shapes[i]);
  return ids;
}

void require(bool holds, const char* name, const std::string& given, const std::string& allowed) {
  if (!holds) refuse_constant(name, given, allowed + " allowed");
}

}  // namespace

void TraceParams::declare(ConstantBinder& constants) {
  constants.names("AVAILABLE_SHAPES", AVAILABLE_SHAPES, kContourNames, 1,
                  "shapes that a demonstration is drawn from", ids_of);
  constants.fixed({{"SHAPE_CIRCLE", SHAPE_CIRCLE},
                   {"SHAPE_SQUARE", SHAPE_SQUARE},
                   {"SHAPE_TRIANGLE", SHAPE_TRIANGLE}});
  constants.integer("NUM_WAYPOINTS", contours.NUM_WAYPOINTS, {24, 500}, "",
                    "control steps in which the red cube traces a shape");
  constants.integer("NUM_CHECKPOINTS", contours.NUM_CHECKPOINTS, {3, ContourSet::kMaxCheckpoints},
                    "", "points of a shape that are checked");
  constants.real("CHECKPOINT_THRESH", contours.CHECKPOINT_THRESH, {0.01, 0.08}, "m",
                 "how near the green cube has to come to them");
  constants.fixed([&] {
    constants.steps("PRE_DEMO_STEPS", PRE_DEMO_STEPS, kPhaseSteps, "time before the demonstration",
                    {"pre_demo_steps", "before the demonstration"});
  });
  constants.range("SHAPE_RADIUS_RANGE", SHAPE_RADIUS_RANGE, {0.04, kFarthest}, "m",
                  "radius of the circle, half a side of the square, or from the triangle's centre "
                  "to its corners",
                  {sequence ? "radii" : "radius", ""});
  if (sequence) declare_sequence(constants);
  smoothness.declare(constants);
  constants.fixed(
      {{"STEPS_PER_WAYPOINT", 1},
       {"CUBE_HALFSIZE", CUBE_HALFSIZE},
       {"SHAPE_CENTER_X_RANGE", ConstantList{SHAPE_CENTER_X_RANGE.low, SHAPE_CENTER_X_RANGE.high}},
       {"SHAPE_CENTER_Y_RANGE", ConstantList{SHAPE_CENTER_Y_RANGE.low, SHAPE_CENTER_Y_RANGE.high}},
       {"GREEN_CUBE_OFFSET_X", GREEN_CUBE_OFFSET_X},
       {"LAMP_OFFSET_X", LAMP_OFFSET_X},
       {"HEIGHT_OFFSET", kTraceHiddenOffset},
       {"SUCCESS_BONUS", sequence ? kTraceShapeSeqSuccessReward : kTraceShapeSuccessReward}});
  declare_lamp(constants);
}

void TraceParams::declare_sequence(ConstantBinder& constants) {
  constexpr Bounds kLength{1, 6};
  constants.integer("MIN_SEQUENCE_LENGTH", MIN_SEQUENCE_LENGTH, kLength, "",
                    "least number of shapes in a sequence");
  constants.integer("MAX_SEQUENCE_LENGTH", MAX_SEQUENCE_LENGTH, kLength, "",
                    "greatest number of shapes in a sequence");
  PressButtonParams button = kSubmitButton;
  constants.fixed([&] { button.declare(constants); });
  constants.fixed({{"BUTTON_OFFSET_FROM_LAMP_X", BUTTON_OFFSET_FROM_LAMP_X},
                   {"BUTTON_OFFSET_FROM_LAMP_Y", BUTTON_OFFSET_FROM_LAMP_Y}});
}

void TraceParams::check(int horizon) const {
  const int checkpoints = contours.NUM_CHECKPOINTS;
  require(checkpoints <= contours.NUM_WAYPOINTS, "NUM_CHECKPOINTS", std::to_string(checkpoints),
          "at most NUM_WAYPOINTS " + std::to_string(contours.NUM_WAYPOINTS));
  require(MIN_SEQUENCE_LENGTH <= MAX_SEQUENCE_LENGTH, "MIN_SEQUENCE_LENGTH",
          std::to_string(MIN_SEQUENCE_LENGTH),
          "at most MAX_SEQUENCE_LENGTH " + std::to_string(MAX_SEQUENCE_LENGTH));
  const double radius = SHAPE_RADIUS_RANGE.high;
  const double corner = farthest_corner();
  require(corner <= kFarthest, "SHAPE_RADIUS_RANGE", shortest(radius),
          "with corners " + shortest(corner) + " m from the centre, at most " +
              shortest(radius * kFarthest / corner) + " for corners within " + shortest(kFarthest) +
              " m");
  const std::string demo = std::to_string(MAX_SEQUENCE_LENGTH) + " x NUM_WAYPOINTS " +
                           std::to_string(contours.NUM_WAYPOINTS) + " =";
  check_horizon(horizon,
                {{"PRE_DEMO_STEPS", PRE_DEMO_STEPS.high},
                 {demo.c_str(), MAX_SEQUENCE_LENGTH * contours.NUM_WAYPOINTS}},
                kTimeToTake + MAX_SEQUENCE_LENGTH * kTimeToTrace);
}

double TraceParams::farthest_corner() const {
  double farthest = 0;
  for (int i = 0; i < AVAILABLE_SHAPES.size(); ++i) {
    farthest = std::max(farthest, farthest_point(AVAILABLE_SHAPES[i]));
  }
  return farthest * SHAPE_RADIUS_RANGE.high;
}

double TraceParams::nearest_point() const {
  double nearest = 1;
  for (int i = 0; i < AVAILABLE_SHAPES.size(); ++i) {
    nearest = std::min(nearest, tasks::nearest_point(AVAILABLE_SHAPES[i]));
  }
  return nearest * SHAPE_RADIUS_RANGE.low;
}

}  // namespace engram::tasks
