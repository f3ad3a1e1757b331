#include "tasks/timed_transfer/expert.h"

#include "tasks/common/grasp_servo.h"
#include "tasks/common/guess_stream.h"
#include "tasks/common/poses.h"

namespace engram::tasks {

void TimedTransferExpert::act(Range envs, Script script, FloatRows actions) const {
  constexpr double kWaitHeight = 0.1;     // m, of the cube: well above the height that counts
  constexpr double kCloseHeight = 0.076;  // m: just above it, from where one step is enough
  constexpr int kNarrow = 4;              // control steps
  const TimeWindow from_signal = window(0);
  const bool narrow = from_signal.end - from_signal.start < kNarrow;
  const double wait_height = narrow ? kCloseHeight : kWaitHeight;
  const State& state = *view_.engine.state;
  for (int env = envs.begin; env < envs.end; ++env) {
    float* action = actions.row(env);
    const Grip grip{.prop = view_.cube, .tool = cube_grasp_orientation(state, env, view_.cube)};
    const Eigen::Vector3d red = prop_pos(state, env, view_.red_disc);
    const int due = due_step(env, script, narrow);
    if (state.elapsed[env] + 1 >= due) {
      const Eigen::Vector3d place(red.x(), red.y(), view_.resting_height);
      if (pick_and_place(state, env, grip, place, action)) hold_tcp(kGripperOpen, action);
    } else if (grasp(state, env, grip, action)) {
      carry(state, env, grip, {red.x(), red.y(), wait_height}, action);
    }
  }
}

// Step count at which the cube is to come down.
int TimedTransferExpert::due_step(int env, Script script, bool narrow) const {
  if (script == Script::kBlind) return view_.signal_step[env] + guessed_count(env);
  if (script == Script::kOracle) return window(view_.signal_step[env]).start;
  // Sweep: the middle of all windows, which lies in as many as possible. The descent takes a step
  // more where there is time for it.
  const StepRange signal = view_.signal_steps;
  const int middle = (window(signal.low).start + window(signal.high).end) / 2;
  return narrow ? middle : middle - 1;
}

// Count of an agent that has not counted: any step up to twice the delay.
int TimedTransferExpert::guessed_count(int env) const {
  return guess_stream(view_.engine, env).integer(0, 2 * view_.delay_steps);
}

}  // namespace engram::tasks
