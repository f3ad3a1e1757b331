#include "tasks/colors/annotator.h"

#include <algorithm>

#include "tasks/common/words.h"

namespace engram::tasks {
namespace {

// Subtasks before the touches; the button, if there is one, comes after them.
constexpr int kRemember = 0;
constexpr int kWait = 1;
constexpr int kFirstTouch = 2;

}  // namespace

// Items of the cue that have been shown so far.
int ColorRecallAnnotator::shown(int env) const {
  if (phase(env) != Phase::kCue) return length();
  return view_.cubes.shown(elapsed(env), view_.clock.cue_end(env));
}

int ColorRecallAnnotator::last_subtask() const {
  return kFirstTouch + length() - (has_button() ? 0 : 1);
}

// In the order of the cue, also where any order will do.
std::vector<std::string> ColorRecallAnnotator::plan(int env) const {
  const bool once = view_.params.rule == ColorRule::kBunch;
  std::vector<std::string> plan = {
      once ? "remember the colors of the cubes"
           : (is_chain() ? "remember the colors of the cubes and their order"
                         : "remember the colors of the cubes, one after the other"),
      "wait"};
  for (int item = 0; item < length(); ++item) {
    plan.push_back(item < shown(env) ? "touch the " + color_name(color(env, item)) + " cube"
                                     : "touch cube " + std::to_string(item + 1) + " of the cue");
  }
  if (has_button()) plan.emplace_back("press the center button");
  return plan;
}

int ColorRecallAnnotator::subtask(int env) const {
  switch (phase(env)) {
    case Phase::kCue:
      return kRemember;
    case Phase::kEmpty:
      return kWait;
    case Phase::kManipulation:
      break;
  }
  const std::int32_t* const first = view_.sequence.row(env);
  const std::int32_t* const found = std::find(first, first + length(), expert_.next_target(env));
  return std::min(kFirstTouch + static_cast<int>(found - first), last_subtask());
}

int ColorRecallAnnotator::subtasks_done(int env) const {
  if (phase(env) != Phase::kManipulation) return subtask(env);
  int touched = 0;
  for (int item = 0; item < length(); ++item) {
    touched += view_.touch.touched(env)[color(env, item)] != 0 ? 1 : 0;
  }
  return std::min(kFirstTouch + touched, last_subtask());
}

std::string ColorRecallAnnotator::memory(int env) const {
  std::vector<std::string> colors;
  colors.reserve(at(length()));
  for (int item = 0; item < shown(env); ++item) colors.push_back(color_name(color(env, item)));
  if (!is_chain()) return "the cubes of the cue: " + enumerate(colors);
  std::string text = "the cubes of the cue in their order:";
  for (std::size_t i = 0; i < colors.size(); ++i) text += (i == 0 ? " " : ", then ") + colors[i];
  return text;
}

int ColorRecallAnnotator::object(int env) const {
  switch (phase(env)) {
    case Phase::kCue:
      return view_.params.rule == ColorRule::kBunch ? -1 : color(env, shown(env) - 1);
    case Phase::kEmpty:
      return -1;
    case Phase::kManipulation:
      break;
  }
  const int next = expert_.next_target(env);
  if (next >= 0) return next;
  return has_button() ? view_.button->cap() : color(env, length() - 1);
}

}  // namespace engram::tasks
