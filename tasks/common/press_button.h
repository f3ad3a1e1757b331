// Press button of several families. A press follows from the position of the TCP, never from
// contact: the cap sinks ahead of the finger.
#pragma once

#include <string>

#include "core/task/task.h"
#include "mjcf/button.h"
#include "mjcf/scene.h"
#include "tasks/common/constant_binder.h"
#include "tasks/common/layout.h"
#include "tasks/common/poses.h"

namespace engram::tasks {

// Named as the class constants.
struct PressButtonParams {
  mjcf::ButtonShape shape;
  double BUTTON_CAP_TRAVEL = 0.014;         // m
  double BUTTON_PRESS_EVENT_RATIO = 0.35;   // of the travel
  double BUTTON_RELEASE_READY_RATIO = 0.2;  // of the travel
  double BUTTON_PRESS_XY_RADIUS = 0.065;    // m
  double BUTTON_PRESS_Z_MARGIN = 0.03;      // m above the unpressed cap
  double REQUIRED_LIFT_HEIGHT = 0.1;        // m above the height at which the press began
  double LIFT_CONFIRM_TOL = 0.015;          // m
  bool radius_counts = false;               // a TCP exactly at the radius is over it
  bool publishes_release = true;            // the release ratio is a class constant

  // Declares those of the button and of a press; then those of the lift, which some families do
  // not ask for.
  void declare(ConstantBinder& constants);
  void declare_lift(ConstantBinder& constants);
  // Throws Error for a button that cannot be, or could not be pressed and released.
  void check() const;

  // Heights of a TCP over the button, m: where it begins to press, where a press begins, and where
  // the button is released again.
  double zone_height() const { return shape.top_height() + BUTTON_PRESS_Z_MARGIN; }
  double event_height() const {
    return zone_height() - BUTTON_CAP_TRAVEL * BUTTON_PRESS_EVENT_RATIO;
  }
  double release_height() const {
    return zone_height() - BUTTON_CAP_TRAVEL * BUTTON_RELEASE_READY_RATIO;
  }
};

// Press depth of a TCP at `height` and at that horizontal distance from the centre, m.
double press_depth(const PressButtonParams& params, double distance, double height);
bool is_pressed(const PressButtonParams& params, double depth);
// Not the opposite of pressed: between the two nothing happens.
bool is_released(const PressButtonParams& params, double depth);

// State of a button between evaluations.
struct PressState {
  bool ready = true;        // was released since the last press
  bool pending = false;     // pressed, and not lifted since
  double start_height = 0;  // of the TCP when the pending, or last, press began; m
};

// Events of one evaluation.
struct PressEvents {
  bool released = false;   // the button became ready again
  bool pressed = false;    // a press began
  bool confirmed = false;  // a press was completed by lifting the tool
};

// True if the TCP is high enough to complete the press.
bool is_lifted(const PressButtonParams& params, const PressState& press, double height);

// One evaluation of the press, release and lift machine. acting: the action phase; enabled:
// whether the family lets presses begin and count now.
PressEvents press_and_lift(const PressButtonParams& params, double depth, double height,
                           bool acting, bool enabled, PressState& press);

// Advances a press without a lift, which counts at once. True if one began.
bool press_once(const PressButtonParams& params, double depth, bool acting, bool enabled,
                PressState& press);

// A button of a scene, with a state per environment.
class PressButton {
 public:
  // Appends the button's props, "<name>_base" and "<name>_cap", to a scene. Columns are named after
  // it too.
  PressButton(mjcf::Scene& scene, const std::string& name, const PressButtonParams& params = {});

  void bind(const Bindings& bindings);
  // A new episode: places the button, unpressed.
  void reset(int env, const Vec2& center, const mjcf::Quat& base_quat = {1, 0, 0, 0}) const;
  // Measures the depth and moves the cap along; to be called once per step, when the scene is
  // brought to its phase. live: false keeps the button up, whatever the tool does.
  void follow_tool(int env, bool live) const;

  // One evaluation, once per step, of the one kind or the other.
  PressEvents press_and_lift(int env, bool acting, bool enabled) const;
  bool press_once(int env, bool acting, bool enabled) const;

  const PressButtonParams& params() const { return params_; }
  Vec2 center(int env) const { return {center_.row(env)[0], center_.row(env)[1]}; }
  double top_height() const { return params_.shape.top_height(); }
  int cap() const { return cap_; }  // index of the prop
  // Poses as observations report them.
  const double* cap_pos(int env) const { return engine_.state->prop_pos_of(env, cap_); }
  Pose base_pose(int env) const { return prop_pose(*engine_.state, env, base_); }
  Pose cap_pose(int env) const { return prop_pose(*engine_.state, env, cap_); }
  // The point just above the unpressed cap, to which goal vectors lead.
  Eigen::Vector3d above(int env) const;
  // Horizontal distance of the TCP, m.
  double distance(int env) const;
  double depth(int env) const { return depth_[env]; }
  double press_fraction(int env) const { return depth_[env] / params_.BUTTON_CAP_TRAVEL; }
  bool pressed(int env) const { return is_pressed(params_, depth_[env]); }
  bool released(int env) const { return is_released(params_, depth_[env]); }
  bool ready(int env) const { return ready_[env] != 0; }
  bool pending(int env) const { return pending_[env] != 0; }
  // Height at which the last press began, m; 0 before any.
  double start_height(int env) const { return start_height_[env]; }
  double lift_target(int env) const { return start_height_[env] + params_.REQUIRED_LIFT_HEIGHT; }
  bool at_lift_target(int env) const;

 private:
  PressState load(int env) const;
  void store(int env, const PressState& press) const;
  void place_cap(int env) const;

  std::string name_;
  PressButtonParams params_;
  int base_;
  int cap_;
  Bindings engine_;
  Column<double> center_;  // (2) m
  Column<double> depth_;   // m
  Column<std::uint8_t> ready_;
  Column<std::uint8_t> pending_;
  Column<double> start_height_;  // m
};

}  // namespace engram::tasks
