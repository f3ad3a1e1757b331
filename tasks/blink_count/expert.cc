#include "tasks/blink_count/expert.h"

#include <algorithm>
#include <string>

#include "tasks/blink_count/count_scale.h"
#include "tasks/common/guess_stream.h"
#include "tasks/common/press_servo.h"
#include "tasks/common/tcp_servo.h"

namespace engram::tasks {
namespace {

constexpr double kTravelHeight = 0.13;  // m: well above both buttons' press zones
constexpr int kTimeToSpare = 4;         // control steps per press by the step count alone

}  // namespace

void BlinkCountExpert::act(Range envs, Script script, FloatRows actions) const {
  for (int env = envs.begin; env < envs.end; ++env) {
    float* action = actions.row(env);
    if (script == Script::kSweep) {
      sweep(env, action);
    } else if (!is_acting(env) || view_.submit_attempted[env] != 0) {
      hold_tcp(kGripperClosed, action);
    } else {
      press(env, script == Script::kBlind ? guess(env) : view_.target[env], action);
    }
  }
}

void BlinkCountExpert::press(int env, int count, float* action) const {
  const PressButton& button = view_.press_count[env] < count ? view_.red : view_.black;
  servo_tcp(*view_.engine.state, env, press_waypoint(button, env, kTravelHeight), kToolDown,
            kGripperClosed, action);
}

// Without memory: the longer the cue, the more blinks. While it lasts, the TCP over the red button
// is the hand of a clock; its last position is the number of presses. When every cue is over, the
// next press follows from the step count.
void BlinkCountExpert::sweep(int env, float* action) const {
  constexpr int kTimeToApproach = 20;
  const State& state = *view_.engine.state;
  const BlinkCountParams& params = view_.params;
  const int start = std::max(kTimeToApproach, params.latest_start());
  const int most = (view_.info.horizon - start) / (params.BLINK_COUNT_RANGE.high + 1);
  const int stride = std::clamp(most, 2, params.steps_per_press() + kTimeToSpare);
  const int since = state.elapsed[env] - start;
  const CountScale scale(params);
  const Vec2 red = view_.red.center(env);
  const int shown = scale.count_at(state.tcp_pos.row(env)[1] - red.y());
  if (since >= stride * shown) {
    servo_tcp(state, env, press_waypoint(view_.black, env, kTravelHeight), kToolDown,
              kGripperClosed, action);
    return;
  }
  const PressButtonParams& button = params.button;
  const bool down = since >= 0 && since % stride < stride / 2;
  const double up = std::max(kTravelHeight, button.event_height() + button.REQUIRED_LIFT_HEIGHT);
  const int count = is_acting(env) ? shown : scale.count_after(state.elapsed[env] + 1);
  servo_tcp(state, env,
            {red.x(), red.y() + scale.offset_of(count), down ? pressing_height(view_.red) : up},
            kToolDown, kGripperClosed, action);
}

// Presses of an agent without memory, or those that the caller has chosen.
int BlinkCountExpert::guess(int env) const {
  const int low = view_.params.BLINK_COUNT_RANGE.low;
  if (const std::span<const int> chosen = choice(env); !chosen.empty()) return low + chosen.front();
  RandomStream random = guess_stream(view_.engine, env);
  return random.integer(low, view_.params.BLINK_COUNT_RANGE.high);
}

ChoiceForm BlinkCountExpert::choice_form() const {
  ChoiceForm form{.question = "How often has the lamp blinked?", .ordered = true};
  for (int n = view_.params.BLINK_COUNT_RANGE.low; n <= view_.params.BLINK_COUNT_RANGE.high; ++n) {
    form.items.push_back(std::to_string(n) + (n == 1 ? " blink" : " blinks"));
  }
  return form;
}

}  // namespace engram::tasks
