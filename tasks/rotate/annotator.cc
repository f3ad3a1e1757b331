#include "tasks/rotate/annotator.h"

#include <cmath>

#include "tasks/common/poses.h"
#include "tasks/common/words.h"
#include "tasks/rotate/peg_angle.h"

namespace engram::tasks {
namespace {

enum Subtask { kMove, kTurn, kRest };

constexpr double kBesidePeg = 0.05;  // m

}  // namespace

std::vector<std::string> RotateAnnotator::plan(int env) const {
  return {"move to the peg",
          rotate_instruction("rotate the peg by {angle_deg} degrees", view_.target[env]),
          "let the peg rest"};
}

int RotateAnnotator::subtask(int env) const {
  const State& state = *view_.engine.state;
  const PegTurn turn =
      peg_turn(peg_angle(state.prop_quat_of(env, kPeg)), view_.initial_yaw[env], view_.target[env]);
  if (std::abs(turn.error) < view_.threshold) return kRest;
  const bool beside =
      tool_is_at(state, env, prop_pos(state, env, kPeg), view_.peg_half_length + kBesidePeg);
  return beside ? kTurn : kMove;
}

// The angle of a turn is measured from where the peg lies in the first image.
std::string RotateAnnotator::memory(int env) const {
  return "the peg pointed first at a yaw of " + in_degrees(view_.initial_yaw[env]);
}

int RotateAnnotator::object(int /*env*/) const { return kPeg; }

}  // namespace engram::tasks
