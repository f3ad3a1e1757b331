// Demonstration of TraceShape and TraceShapeSeq: a red cube traces one shape or several, one after
// the other, while a lamp glows red; then the lamp turns green, the red cube is gone and a green
// cube waits to be moved (docs/tasks/trace_shape.md).
#pragma once

#include <optional>

#include "core/math/random.h"
#include "core/task/task.h"
#include "mjcf/scene.h"
#include "tasks/common/lamp.h"
#include "tasks/common/poses.h"
#include "tasks/common/random_variables.h"
#include "tasks/common/state_row.h"
#include "tasks/common/task_options.h"
#include "tasks/trace_shape/contour.h"
#include "tasks/trace_shape/params.h"

namespace engram::tasks {

enum class TracePhase { kPreDemo, kDemo, kAction };

// Random variables of an episode.
struct TraceVariables {
  TraceVariables(RandomVariables list, const TraceParams& params);

  VariableHandle shapes;
  RealVariable radii;
  RealVariable center_x;
  RealVariable center_y;
  VariableHandle rotations;
  IntegerVariable pre_demo_steps;
  std::optional<IntegerVariable> length;  // of a sequence
};

class TraceDemo {
 public:
  // Appends red cube, green cube and lamp to a scene, and an invisible body for the red cube;
  // random variables and options to the description.
  TraceDemo(mjcf::Scene& scene, TaskInfo& info, const TraceParams& params);

  void bind(const Bindings& bindings);
  void reset(const Episode& episode) const;
  void advance(int env) const;

  TracePhase phase(int env) const;
  bool is_acting(int env) const { return phase(env) == TracePhase::kAction; }
  // The number of steps after which the demonstration is over.
  int demo_end(int env) const { return pre_demo_steps_[env] + contours_.waypoints() * length(env); }

  const TraceParams& params() const { return params_; }
  const ContourSet& contours() const { return contours_; }
  // Shapes of the demonstration.
  int length(int env) const { return length_[env]; }
  // Their ids, then -1.
  const std::int32_t* shapes(int env) const { return shapes_.row(env); }
  Contour contour(int env, int element) const;
  // Shapes that may be shown, and each of them with place, size and turn of an element.
  int candidates() const { return params_.AVAILABLE_SHAPES.size(); }
  Contour candidate(int env, int element, int index) const {
    return contour_as(env, element, params_.AVAILABLE_SHAPES[index]);
  }
  // Draws shape, size and turn, as a demonstration does.
  Contour sample_contour(int env, RandomStream& random) const;

  // Position on the table of the shapes' common centre, of the lamp and of the green cube.
  Vec2 center(int env) const { return {center_.row(env)[0], center_.row(env)[1]}; }
  Vec2 lamp_at(int env) const;
  Vec2 green_at(int env) const;

  int red_cube() const { return red_; }
  int green_cube() const { return green_; }
  // Declares the waypoints of the demonstration in a row of what was drawn.
  template <class Visitor>
  void list_waypoints(Visitor& row, int env) const {
    row.field("waypoints", params_.MAX_SEQUENCE_LENGTH * contours_.waypoints() * 2, "m",
              "x and y of each, shape after shape, then 0", [&](RowWriter& out) {
                for (int element = 0; element < params_.MAX_SEQUENCE_LENGTH; ++element) {
                  const bool shown = element < length(env);
                  const Contour shape = contour(env, element);
                  for (int i = 0; i < contours_.waypoints(); ++i) {
                    const Vec2 at = shown ? shape.waypoint(i) : Vec2(0, 0);
                    out.add(at.data(), 2);
                  }
                }
              });
  }
  // The first fields of the state observation.
  template <class Visitor>
  void list_cubes(Visitor& row, int env) const {
    row.field("red_cube_pose", 7, "m", "", [&] { return prop_pose(*engine_.state, env, red_); });
    row.field("green_cube_pose", 7, "m", "",
              [&] { return prop_pose(*engine_.state, env, green_); });
  }

 private:
  // Place of the red cube when `elapsed` steps have passed, before the action phase.
  struct Place {
    int element = 0;
    int waypoint = 0;
  };
  Place place_at(int env, int elapsed) const;
  void put_red(int env, const Place& place) const;
  void put_green(int env) const;
  void make_room_for_red(int env) const;
  void light_lamp(int env) const;

  Contour contour_as(int env, int element, int shape) const;
  int draw_shape(RandomStream& random) const;
  double draw_radius(RandomStream& random) const;

  TraceParams params_;
  TraceVariables variables_;
  TaskOption red_pushes_green_;
  ContourSet contours_;
  int red_;
  int green_;
  Lamp lamp_;
  int red_body_;
  bool pushes_ = false;  // the red cube has its body
  Bindings engine_;
  Column<std::int32_t> length_;
  Column<std::int32_t> shapes_;  // (most elements)
  Column<double> radii_;         // (most elements) m
  Column<double> rotations_;     // (most elements) rad
  Column<double> center_;        // (2) m
  Column<std::int32_t> pre_demo_steps_;
};

// Moves the green cube in y away from the red one until the two do not overlap. `half`: of a box
// around the green one, m.
Vec2 clear_of_red(const Vec2& green, const Vec2& red,
                  const Vec2& half = Vec2::Constant(CUBE_HALFSIZE));

}  // namespace engram::tasks
