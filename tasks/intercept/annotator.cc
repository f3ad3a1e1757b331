#include "tasks/intercept/annotator.h"

#include "tasks/common/poses.h"
#include "tasks/common/words.h"

namespace engram::tasks {
namespace {

enum Subtask { kMove, kMeet, kHold };

constexpr double kAtBall = 0.07;  // m

}  // namespace

std::vector<std::string> InterceptAnnotator::plan(int /*env*/) const {
  if (goal_ == InterceptGoal::kDeflect) {
    return {"move to the path of the ball", "bring the ball to the target"};
  }
  return {"move to the path of the ball", "grasp the ball", "hold the ball still"};
}

int InterceptAnnotator::subtask(int env) const {
  const State& state = *engine_.state;
  if (goal_ == InterceptGoal::kGrab && is_grasping(state, env, kBallProp)) return kHold;
  return tool_is_at(state, env, prop_pos(state, env, kBallProp), kAtBall) ? kMeet : kMove;
}

int InterceptAnnotator::object(int /*env*/) const { return kBallProp; }

}  // namespace engram::tasks
