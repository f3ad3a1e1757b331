#include "tasks/take_it_back/annotator.h"

#include "tasks/common/poses.h"
#include "tasks/common/words.h"
#include "tasks/take_it_back/layout.h"

namespace engram::tasks {
namespace {

enum Subtask { kMove, kThere, kBack };

constexpr double kAtCube = 0.07;  // m

}  // namespace

std::vector<std::string> TakeItBackAnnotator::plan(int /*env*/) const {
  return {"move to the cube", "bring the cube onto the red target",
          "bring the cube back to where it was first"};
}

int TakeItBackAnnotator::subtask(int env) const {
  if (view_.reached[env] != 0) return kBack;
  const State& state = *view_.engine.state;
  return tool_is_at(state, env, prop_pos(state, env, kCube), kAtCube) ? kThere : kMove;
}

// The cube stands there in the first image.
std::string TakeItBackAnnotator::memory(int env) const {
  const double* initial = view_.initial.row(env);
  return "the cube was first at x = " + in_centimetres(initial[0]) +
         ", y = " + in_centimetres(initial[1]);
}

int TakeItBackAnnotator::object(int /*env*/) const { return kCube; }

}  // namespace engram::tasks
