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

constexpr double kTravelHeight = 0.115;  // m: the TCP between two touches touches nothing
constexpr double kMaxAboveTouch = 0.02;  // m: clear of the cube, even when it overshoots
// Where touches are all:
constexpr double kTravelMargin = 0.005;               // m above where a cube can be touched
const Eigen::Vector3d kWaitingPlace(-0.06, 0, 0.08);  // m: amid the cubes, above them

// Passing touches: the goal is that much above and before the touch point, as far as the touch
// radius allows, and the TCP stops that near to it. Fingers of a tilted hand stay clear of the
// cubes, and a cube beside is farther away.
struct Passing {
  double above;  // m
  double before;
  double rest;
};
Passing passing(double touch_radius) {
  const double scale = std::min(touch_radius, 0.02);
  return {0.7 * scale, 0.4 * scale, 0.9 * scale};
}

// Without memory, in control steps:
constexpr int kMaxPerTouch = 20;
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
    if (!is_acting(env)) {
      wait(env, action);
      continue;
    }
    ColorPermutation guessed{};
    const int next =
        script == Script::kBlind ? next_color(env, guess(env, guessed)) : next_target(env);
    if (is_done(env, next)) {
      hold_tcp(kGripperOpen, action);
    } else if (next < 0) {
      press(env, action);
    } else {
      touch(env, next, action);
    }
  }
}

// next: -1 once all have been touched.
bool ColorRecallExpert::is_done(int env, int next) const {
  return view_.button == nullptr ? next < 0 : (*view_.button_pressed)[env] != 0;
}

int ColorRecallExpert::next_target(int env) const {
  return next_color(env, {view_.sequence.row(env), at(view_.params.SEQUENCE_LENGTH)});
}

// Waypoint that stops a little above the touch point.
Eigen::Vector3d ColorRecallExpert::touch_waypoint(int env, int color) const {
  const double above = std::min(kMaxAboveTouch, 0.6 * view_.touch.radius());
  return view_.touch.touch_point(env, color) + Eigen::Vector3d(0, 0, above);
}

double ColorRecallExpert::travel_height(int env, int color) const {
  if (view_.button != nullptr) return kTravelHeight;
  return view_.touch.touch_point(env, color).z() + view_.touch.radius() + kTravelMargin;
}

// True where actions are joint steps and touches are all: the horizon leaves hardly enough of such
// steps for seven touches.
bool ColorRecallExpert::leaves_early() const {
  return view_.button == nullptr && view_.engine.action.width() > kArmJoints;
}

// Where touches are all, the tool waits amid the places, so that it need not come down first.
void ColorRecallExpert::wait(int env, float* action) const {
  if (view_.button != nullptr) {
    hold_tcp(kGripperOpen, action);
  } else {
    approach(env, kWaitingPlace, action);
  }
}

void ColorRecallExpert::approach(int env, const Eigen::Vector3d& goal, float* action) const {
  const State& state = *view_.engine.state;
  if (leaves_early()) {
    reach_point(state, *view_.engine.arm, env, goal, kGripperOpen, action);
  } else {
    servo_tcp(state, env, goal, kToolDown, kGripperOpen, action);
  }
}

void ColorRecallExpert::touch(int env, int color, float* action) const {
  if (leaves_early()) {
    touch_in_passing(env, color, action);
    return;
  }
  const double height = travel_height(env, color);
  approach(env, descend(*view_.engine.state, env, touch_waypoint(env, color), height), action);
}

// Moves at one height, just above the cubes, to the near edge of where the cube is touched, and
// stops there for a step.
void ColorRecallExpert::touch_in_passing(int env, int color, float* action) const {
  constexpr double kCoasting = 0.02;  // s: so far the TCP moves on when a stop is commanded
  const State& state = *view_.engine.state;
  const auto [above, before, rest] = passing(view_.touch.radius());
  const Eigen::Vector3d point = view_.touch.touch_point(env, color);
  const Eigen::Vector3d way = point - tcp_pos(state, env);
  if ((way - kCoasting * tcp_velocity(state, *view_.engine.arm, env)).norm() < rest) {
    hold_tcp(kGripperOpen, action);
    return;
  }
  Eigen::Vector3d goal = point + Eigen::Vector3d(0, 0, above);
  const Vec2 across = way.head<2>();
  goal.head<2>() -= std::min(before, across.norm()) * across.normalized();
  approach(env, goal, action);
}

void ColorRecallExpert::press(int env, float* action) const {
  const Eigen::Vector3d goal = press_waypoint(*view_.button, env, kTravelHeight);
  servo_tcp(*view_.engine.state, env, goal, kToolDown, kGripperClosed, action);
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
    wait(env, action);
    return;
  }
  const State& state = *view_.engine.state;
  const int length = view_.params.SEQUENCE_LENGTH;
  const int start = view_.params.latest_start();
  const int last = view_.button == nullptr ? 0 : kPressSteps + kLiftSteps;
  const int left = view_.info.horizon - start - last;
  const int stride = std::clamp(left / length, 1, kMaxPerTouch);
  const int since = state.elapsed[env] - start;
  const int turn = std::max(0, since / stride);
  if (turn >= length) {
    sweep_button(env, since - stride * length, action);
    return;
  }
  const int color = color_in_row(env, turn);
  if (since >= 0) {
    touch(env, color, action);
    return;
  }
  Eigen::Vector3d goal = touch_waypoint(env, color);
  goal.z() = travel_height(env, color);
  approach(env, descend(state, env, goal, goal.z()), action);
}

// since: steps since the last touch.
void ColorRecallExpert::sweep_button(int env, int since, float* action) const {
  if (view_.button == nullptr) {
    hold_tcp(kGripperOpen, action);
    return;
  }
  const State& state = *view_.engine.state;
  const PressButton& button = *view_.button;
  const Vec2 center = button.center(env);
  Eigen::Vector3d goal(center.x(), center.y(), pressing_height(button));
  if (since < kPressSteps) {
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

// Cubes that an agent without memory would touch, one after another, or that the caller has chosen.
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
