#include "tasks/trace_shape/annotator.h"

#include <algorithm>

namespace engram::tasks {
namespace {

enum Subtask { kWatch, kPickUp, kFirstTrace };

}  // namespace

int TraceAnnotator::shown(int env) const {
  const int left = std::max(0, view_.demo.demo_end(env) - view_.engine.state->elapsed[env]);
  const int waypoints = view_.demo.contours().waypoints();
  return std::max(0, view_.demo.length(env) - (left + waypoints - 1) / waypoints);
}

// In a made-up snapshot there may be no shape.
std::string TraceAnnotator::shape_name(int env, int element) const {
  const int shape = view_.demo.shapes(env)[element];
  return shape < 0 ? "shape" : kContourNames[at(shape)];
}

// The number of shapes is unknown before the demonstration is over.
std::vector<std::string> TraceAnnotator::plan(int env) const {
  std::vector<std::string> plan = {"watch the red cube", "pick up the green cube"};
  if (view_.demo.is_acting(env)) {
    for (int element = 0; element < view_.demo.length(env); ++element) {
      plan.push_back("trace the " + shape_name(env, element));
    }
  } else {
    plan.emplace_back(is_sequence() ? "trace the shapes in their order" : "trace the shape");
  }
  if (is_sequence()) plan.emplace_back("press the button");
  return plan;
}

int TraceAnnotator::subtask(int env) const {
  if (!view_.demo.is_acting(env)) return kWatch;
  const bool begun = view_.visited[env] != 0 || closed(env) > 0;
  if (!begun && !is_grasping(*view_.engine.state, env, view_.demo.green_cube())) return kPickUp;
  return kFirstTrace + closed(env);
}

std::string TraceAnnotator::memory(int env) const {
  const int shapes = shown(env);
  if (shapes == 0) return {};
  std::string text = "the red cube traced";
  for (int element = 0; element < shapes; ++element) {
    text += (element == 0 ? " a " : ", then a ") + shape_name(env, element);
  }
  return text;
}

int TraceAnnotator::object(int env) const {
  if (!view_.demo.is_acting(env)) return view_.demo.red_cube();
  const bool all = is_sequence() && closed(env) >= view_.demo.length(env);
  return all ? view_.button->cap() : view_.demo.green_cube();
}

}  // namespace engram::tasks
