#include "tasks/remember/annotator.h"

#include "tasks/common/poses.h"
#include "tasks/common/words.h"

namespace engram::tasks {
namespace {

enum Subtask { kRemember, kWait, kMove, kTouch };

constexpr double kApproached = 0.05;  // m beyond the reach of a touch

}  // namespace

std::string ObjectRecallAnnotator::cue_subtask() const {
  const bool cubes = view_.objects.vocabulary() == Vocabulary::kColor;
  if (view_.imposter)
    return std::string("remember which ") + (cubes ? "cubes" : "objects") + " are shown";
  switch (view_.objects.vocabulary()) {
    case Vocabulary::kColor:
      return "remember the color of the cube";
    case Vocabulary::kShape:
      return "remember the shape of the object";
    case Vocabulary::kShapeAndColor:
      break;
  }
  return "remember the shape and color of the object";
}

// An imposter has not been seen before it stands among the others.
std::string ObjectRecallAnnotator::target_words(int env) const {
  if (!view_.imposter || phase(env) == Phase::kManipulation)
    return "the " + view_.objects.name(view_.target[env]);
  const bool cubes = view_.objects.vocabulary() == Vocabulary::kColor;
  return std::string("the ") + (cubes ? "cube" : "object") + " that was not shown";
}

std::vector<std::string> ObjectRecallAnnotator::plan(int env) const {
  const std::string target = target_words(env);
  return {cue_subtask(), "wait", "move to " + target, "touch " + target};
}

int ObjectRecallAnnotator::subtask(int env) const {
  switch (phase(env)) {
    case Phase::kCue:
      return kRemember;
    case Phase::kEmpty:
      return kWait;
    case Phase::kManipulation:
      break;
  }
  const State& state = *view_.engine.state;
  const bool near = tool_is_at(state, env, prop_pos(state, env, view_.target[env]),
                               view_.goal_thresh + kApproached);
  return near ? kTouch : kMove;
}

// The cue shows from the first image on.
std::string ObjectRecallAnnotator::memory(int env) const {
  if (!view_.imposter) return "the cue was a " + view_.objects.name(view_.target[env]);
  std::vector<std::string> shown;
  for (int key = 0; key < view_.objects.count(); ++key) {
    if (key != view_.target[env]) shown.push_back("the " + view_.objects.name(key));
  }
  return "the cue showed " + enumerate(shown);
}

int ObjectRecallAnnotator::object(int env) const {
  switch (phase(env)) {
    case Phase::kCue:
      return view_.imposter ? -1 : view_.target[env];
    case Phase::kEmpty:
      return -1;
    case Phase::kManipulation:
      break;
  }
  return view_.target[env];
}

}  // namespace engram::tasks
