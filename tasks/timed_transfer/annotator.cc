#include "tasks/timed_transfer/annotator.h"

#include "tasks/common/poses.h"

namespace engram::tasks {
namespace {

enum Subtask { kWait, kGrasp, kHold, kPlace };

}  // namespace

CountPhase TimedTransferAnnotator::count(int env) const {
  const int signal = view_.signal_step[env];
  const TimeWindow window = time_window(signal, view_.delay_steps, view_.tolerance, view_.rounding);
  return count_phase(view_.engine.state->elapsed[env], signal, window);
}

std::vector<std::string> TimedTransferAnnotator::plan(int /*env*/) const {
  return {"wait for the lamp to turn green", "count the steps and grasp the blue cube",
          "count the steps and hold the blue cube",
          "put the blue cube onto the red disc at step " + std::to_string(view_.delay_steps)};
}

// The last one begins a step before the window, so that the cube arrives within it.
int TimedTransferAnnotator::subtask(int env) const {
  const State& state = *view_.engine.state;
  const CountPhase phase = count(env);
  if (!phase.signal_on) return kWait;
  const TimeWindow window =
      time_window(view_.signal_step[env], view_.delay_steps, view_.tolerance, view_.rounding);
  if (state.elapsed[env] + 1 >= window.start) return kPlace;
  return is_grasping(state, env, view_.cube) ? kHold : kGrasp;
}

std::string TimedTransferAnnotator::memory(int env) const {
  if (!count(env).signal_on) return {};
  return "the lamp turned green at step " + std::to_string(view_.signal_step[env]);
}

int TimedTransferAnnotator::object(int env) const {
  switch (subtask(env)) {
    case kWait:
      return view_.lamp.bulb();
    case kPlace:
      return view_.red_disc;
    default:
      return view_.cube;
  }
}

}  // namespace engram::tasks
