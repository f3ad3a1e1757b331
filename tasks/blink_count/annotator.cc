#include "tasks/blink_count/annotator.h"

#include <algorithm>

namespace engram::tasks {
namespace {

constexpr int kCount = 0;
constexpr int kFirstPress = 1;

std::string times(int number) {
  return std::to_string(number) + (number == 1 ? " time" : " times");
}

}  // namespace

// The number of presses is known when the phase lamp turns green.
std::vector<std::string> BlinkCountAnnotator::plan(int env) const {
  std::vector<std::string> plan = {"count how often the lamp blinks"};
  if (!is_acting(env)) {
    plan.emplace_back("press the red button as often as the lamp blinked");
  } else {
    const std::string all = std::to_string(view_.target[env]);
    for (int press = 1; press <= view_.target[env]; ++press) {
      plan.push_back("press the red button, press " + std::to_string(press) + " of " + all);
    }
  }
  plan.emplace_back("press the black button");
  return plan;
}

int BlinkCountAnnotator::subtask(int env) const {
  if (!is_acting(env)) return kCount;
  return kFirstPress + std::min(view_.presses[env], view_.target[env]);
}

std::string BlinkCountAnnotator::memory(int env) const {
  const int begun = view_.blinks.begun(env, view_.target[env], elapsed(env));
  if (begun == 0) return {};
  return (is_acting(env) ? "the lamp blinked " : "the lamp has blinked so far ") + times(begun);
}

int BlinkCountAnnotator::object(int env) const {
  if (!is_acting(env)) return view_.lamp.bulb();
  return view_.presses[env] < view_.target[env] ? view_.red.cap() : view_.black.cap();
}

}  // namespace engram::tasks
