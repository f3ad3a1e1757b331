#include "tasks/colors/expert.h"

#include <algorithm>
#include <array>

#include "core/base/index.h"
#include "core/math/real_functions.h"
#include "tasks/common/guess_stream.h"
#include "tasks/common/press_servo.h"
#include "tasks/common/tcp_servo.h"

namespace engram::tasks {
namespace {

constexpr double kTravelHeight = 0.115;   // m: the TCP between two touches touches nothing
constexpr double kMostAboveTouch = 0.02;  // m: clear of the cube, even when it overshoots

// Without memory, in control steps:
constexpr int kMostPerTouch = 20;
constexpr int kPressSteps = 14;  // to the button, and down
constexpr int kLiftSteps = 8;

}  // namespace

void ColorRecallExpert::act(Range envs, Script script, FloatRows actions) const {
  for (int env = envs.begin; env < envs.end; ++env) {
    float* action = actions.row(env);
    if (script == Script::kSweep) {
      sweep(env, action);
      continue;
    }
    if (!is_acting(env) || view_.button_pressed[env] != 0) {
      hold_tcp(kGripperOpen, action);
      continue;
    }
    ColorPermutation guessed{};
    const int next =
        script == Script::kBlind ? next_color(env, guess(env, guessed)) : next_target(env);
    touch_or_press(env, next, action);
  }
}

int ColorRecallExpert::next_target(int env) const {
  return next_color(env, {view_.sequence.row(env), at(view_.params.SEQUENCE_LENGTH)});
}

// Waypoint that stops a little above the touch point.
Eigen::Vector3d ColorRecallExpert::touch_waypoint(int env, int color) const {
  const double above = std::min(kMostAboveTouch, 0.6 * view_.touch.radius());
  return view_.touch.touch_point(env, color) + Eigen::Vector3d(0, 0, above);
}

// color: -1 once all have been touched.
void ColorRecallExpert::touch_or_press(int env, int color, float* action) const {
  const State& state = *view_.engine.state;
  const Eigen::Vector3d goal = color < 0
                                   ? press_waypoint(view_.button, env, kTravelHeight)
                                   : descend(state, env, touch_waypoint(env, color), kTravelHeight);
  const double gripper = color < 0 ? kGripperClosed : kGripperOpen;
  servo_tcp(state, env, goal, kToolDown, gripper, action);
}

// Next of the cubes to be touched, -1 if all have been. Without an order, the row of cubes is swept
// from the end that is nearer.
int ColorRecallExpert::next_color(int env, std::span<const std::int32_t> targets) const {
  int ends[2] = {-1, -1};
  double angles[2] = {0, 0};
  for (const std::int32_t color : targets) {
    if (view_.touch.touched(env)[color] != 0) continue;
    if (view_.rule == ColorRule::kSeqStrict || view_.rule == ColorRule::kChain) return color;
    const Vec2 at = view_.cubes.slot(env, color);
    const double angle = real::atan2(at.y(), at.x() - kArcX);
    for (int end = 0; end < 2; ++end) {
      const bool further = end == 0 ? angle < angles[end] : angle > angles[end];
      if (ends[end] >= 0 && !further) continue;
      ends[end] = color;
      angles[end] = angle;
    }
  }
  if (ends[0] < 0) return -1;
  const Eigen::Map<const Eigen::Vector3d> tcp(view_.engine.state->tcp_pos.row(env));
  const auto distance = [&](int color) {
    return (view_.cubes.slot(env, color) - tcp.head<2>()).norm();
  };
  return distance(ends[0]) <= distance(ends[1]) ? ends[0] : ends[1];
}

// Without memory: touches the first cubes of the row, then presses the button, by the step count.
// A touch cannot be taken back, so that there is nothing to be tried.
void ColorRecallExpert::sweep(int env, float* action) const {
  if (!is_acting(env)) {
    hold_tcp(kGripperOpen, action);
    return;
  }
  const State& state = *view_.engine.state;
  const int length = view_.params.SEQUENCE_LENGTH;
  const int start = view_.params.latest_start();
  const int left = view_.info.horizon - start - kPressSteps - kLiftSteps;
  const int stride = std::clamp(left / length, 1, kMostPerTouch);
  const int since = state.elapsed[env] - start;
  const int turn = std::max(0, since / stride);
  if (turn < length) {
    Eigen::Vector3d goal = touch_waypoint(env, color_in_row(env, turn));
    if (since < 0) goal.z() = kTravelHeight;
    servo_tcp(state, env, descend(state, env, goal, kTravelHeight), kToolDown, kGripperOpen,
              action);
    return;
  }
  const PressButton& button = view_.button;
  const Vec2 center = button.center(env);
  Eigen::Vector3d goal(center.x(), center.y(), pressing_height(button));
  if (since - stride * length < kPressSteps) {
    goal = descend(state, env, goal, kTravelHeight);
  } else {
    goal.z() = button.params().event_height() + button.params().REQUIRED_LIFT_HEIGHT;
  }
  servo_tcp(state, env, goal, kToolDown, kGripperClosed, action);
}

// Colour of a cube by its place in the row, as all can see it.
int ColorRecallExpert::color_in_row(int env, int place) const {
  std::array<double, COLOR_MAPPING.size()> angles{};
  ColorPermutation storage{};
  const auto colors = std::span(storage).first(at(view_.params.COLORS));
  for (int color = 0; color < view_.params.COLORS; ++color) {
    const double* pos = view_.engine.state->prop_pos_of(env, color);
    const auto index = at(color);
    colors[index] = color;
    angles[index] = real::atan2(pos[1], pos[0] - kArcX);
  }
  const auto angle = [&](int color) { return angles[at(color)]; };
  std::ranges::sort(colors, {}, angle);
  return colors[at(place)];
}

// Cubes that an agent without memory would touch, one after another, or that somebody has chosen.
std::span<const std::int32_t> ColorRecallExpert::guess(int env, ColorPermutation& storage) const {
  if (const std::span<const int> chosen = choice(env); !chosen.empty()) return chosen;
  return shuffled_colors(view_.params.COLORS, storage, guess_stream(view_.engine, env))
      .first(at(view_.params.SEQUENCE_LENGTH));
}

ChoiceForm ColorRecallExpert::choice_form() const {
  const bool ordered = view_.params.rule == ColorRule::kChain;
  ChoiceForm form{.question = ordered ? "Which cubes are to be touched, in which order?"
                                      : "Which cubes are to be touched?",
                  .least = view_.params.SEQUENCE_LENGTH,
                  .most = view_.params.SEQUENCE_LENGTH};
  for (int color = 0; color < view_.params.COLORS; ++color) {
    form.items.push_back("the " + color_name(color) + " cube");
  }
  return form;
}

}  // namespace engram::tasks
