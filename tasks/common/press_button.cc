#include "tasks/common/press_button.h"

#include <algorithm>

#include "core/base/error.h"
#include "core/base/join.h"

namespace engram::tasks {
namespace {

// Throws Error unless value <= most.
void require(const char* name, double value, double most, const char* what) {
  if (value <= most) return;
  refuse_constant(name, shortest(value), "at most " + shortest(most) + ", " + what + ", allowed");
}

}  // namespace

void PressButtonParams::declare(ConstantBinder& constants) {
  constants.reals("BUTTON_BASE_HALF_SIZE", shape.BUTTON_BASE_HALF_SIZE, {0.005, 0.1}, "m",
                  "half the sides and half the height of the button's base");
  constants.real("BUTTON_CAP_RADIUS", shape.BUTTON_CAP_RADIUS, {0.005, 0.1}, "m",
                 "radius of the button's cap");
  constants.real("BUTTON_CAP_HALF_HEIGHT", shape.BUTTON_CAP_HALF_HEIGHT, {0.002, 0.03}, "m",
                 "half the height of the button's cap");
  constants.real("BUTTON_CAP_TRAVEL", BUTTON_CAP_TRAVEL, {0.002, 0.05}, "m",
                 "how far the cap sinks");
  constants.real("BUTTON_PRESS_EVENT_RATIO", BUTTON_PRESS_EVENT_RATIO, {0.05, 1}, "",
                 "share of the travel at which a press begins");
  constants
      .real("BUTTON_RELEASE_READY_RATIO", BUTTON_RELEASE_READY_RATIO, {0, 0.95}, "",
            "share of the travel at which the button is released again")
      .published = publishes_release;
  constants.real("BUTTON_PRESS_XY_RADIUS", BUTTON_PRESS_XY_RADIUS, {0.01, 0.2}, "m",
                 "how near the button's axis the tool has to be");
  constants.real("BUTTON_PRESS_Z_MARGIN", BUTTON_PRESS_Z_MARGIN, {0.015, 0.1}, "m",
                 "how far above the cap the tool begins to press");
}

void PressButtonParams::declare_lift(ConstantBinder& constants) {
  constants.real("REQUIRED_LIFT_HEIGHT", REQUIRED_LIFT_HEIGHT, {0.02, 0.3}, "m",
                 "how far above the height of a press the tool has to rise until it counts");
  constants.fixed({{"LIFT_CONFIRM_TOL", LIFT_CONFIRM_TOL}});
}

void PressButtonParams::check() const {
  const mjcf::Vec3& base = shape.BUTTON_BASE_HALF_SIZE;
  require("BUTTON_CAP_RADIUS", shape.BUTTON_CAP_RADIUS, std::min(base[0], base[1]),
          "half the base's side");
  require("BUTTON_CAP_TRAVEL", BUTTON_CAP_TRAVEL, 2 * shape.BUTTON_CAP_HALF_HEIGHT,
          "the cap's height");
  if (BUTTON_RELEASE_READY_RATIO < BUTTON_PRESS_EVENT_RATIO) return;
  refuse_constant(
      "BUTTON_RELEASE_READY_RATIO", shortest(BUTTON_RELEASE_READY_RATIO),
      "less than BUTTON_PRESS_EVENT_RATIO " + shortest(BUTTON_PRESS_EVENT_RATIO) + " allowed");
}

double press_depth(const PressButtonParams& params, double distance, double height) {
  const bool over = params.radius_counts ? distance <= params.BUTTON_PRESS_XY_RADIUS
                                         : distance < params.BUTTON_PRESS_XY_RADIUS;
  if (!over) return 0;
  const double raw = params.zone_height() - height;
  return std::clamp(raw, 0.0, params.BUTTON_CAP_TRAVEL);
}

bool is_pressed(const PressButtonParams& params, double depth) {
  return depth >= params.BUTTON_CAP_TRAVEL * params.BUTTON_PRESS_EVENT_RATIO;
}

bool is_released(const PressButtonParams& params, double depth) {
  return depth <= params.BUTTON_CAP_TRAVEL * params.BUTTON_RELEASE_READY_RATIO;
}

bool is_lifted(const PressButtonParams& params, const PressState& press, double height) {
  return height >= press.start_height + params.REQUIRED_LIFT_HEIGHT - params.LIFT_CONFIRM_TOL;
}

PressEvents press_and_lift(const PressButtonParams& params, double depth, double height,
                           bool acting, bool enabled, PressState& press) {
  PressEvents events;
  events.released = !press.ready && is_released(params, depth) && acting;
  press.ready |= events.released;
  events.pressed = is_pressed(params, depth) && press.ready && acting && enabled && !press.pending;
  if (events.pressed) press = {.ready = false, .pending = true, .start_height = height};
  events.confirmed =
      press.pending && is_lifted(params, press, height) && press.ready && acting && enabled;
  if (events.confirmed) press.pending = false;
  return events;
}

bool press_once(const PressButtonParams& params, double depth, bool acting, bool enabled,
                PressState& press) {
  press.ready |= is_released(params, depth) && acting;
  const bool pressed = is_pressed(params, depth) && press.ready && acting && enabled;
  if (pressed) press.ready = false;
  return pressed;
}

PressButton::PressButton(mjcf::Scene& scene, const std::string& name,
                         const PressButtonParams& params)
    : name_(name), params_(params), base_(static_cast<int>(scene.props.size())), cap_(base_ + 1) {
  scene.props.push_back(mjcf::button_base(name + "_base", params.shape));
  scene.props.push_back(mjcf::button_cap(name + "_cap", params.shape, params.BUTTON_CAP_TRAVEL));
}

void PressButton::bind(const Bindings& bindings) {
  engine_ = bindings;
  ColumnStore& memory = *bindings.memory;
  center_ = memory.add<double>(name_ + "_xy", 2, "m");
  depth_ = memory.add<double>(name_ + "_depth", 1, "m");
  ready_ = memory.add<std::uint8_t>(name_ + "_ready");
  pending_ = memory.add<std::uint8_t>(name_ + "_pending");
  start_height_ = memory.add<double>(name_ + "_start_height", 1, "m");
}

void PressButton::reset(int env, const Vec2& center, const mjcf::Quat& base_quat) const {
  center_.row(env)[0] = center.x();
  center_.row(env)[1] = center.y();
  depth_[env] = 0;
  store(env, PressState{});
  const double base[3] = {center.x(), center.y(), params_.shape.base_height()};
  engine_.state->place_prop(env, base_, base, base_quat.data());
  place_cap(env);
}

void PressButton::follow_tool(int env, bool live) const {
  const double height = engine_.state->tcp_pos.row(env)[2];
  const double depth = live ? press_depth(params_, distance(env), height) : 0.0;
  if (depth == depth_[env]) return;
  depth_[env] = depth;
  place_cap(env);
}

PressEvents PressButton::press_and_lift(int env, bool acting, bool enabled) const {
  PressState press = load(env);
  const double height = engine_.state->tcp_pos.row(env)[2];
  const PressEvents events =
      tasks::press_and_lift(params_, depth_[env], height, acting, enabled, press);
  store(env, press);
  return events;
}

bool PressButton::press_once(int env, bool acting, bool enabled) const {
  PressState press = load(env);
  const bool pressed = tasks::press_once(params_, depth_[env], acting, enabled, press);
  store(env, press);
  return pressed;
}

Eigen::Vector3d PressButton::above(int env) const {
  constexpr double kAbove = 0.005;  // m
  const Vec2 xy = center(env);
  return {xy.x(), xy.y(), top_height() + kAbove};
}

double PressButton::distance(int env) const {
  const double* tcp = engine_.state->tcp_pos.row(env);
  return (Vec2(tcp[0], tcp[1]) - center(env)).norm();
}

bool PressButton::at_lift_target(int env) const {
  return is_lifted(params_, load(env), engine_.state->tcp_pos.row(env)[2]);
}

PressState PressButton::load(int env) const {
  return {ready(env), pending(env), start_height_[env]};
}

void PressButton::store(int env, const PressState& press) const {
  ready_[env] = press.ready ? 1 : 0;
  pending_[env] = press.pending ? 1 : 0;
  start_height_[env] = press.start_height;
}

void PressButton::place_cap(int env) const {
  const Vec2 xy = center(env);
  const double pos[3] = {xy.x(), xy.y(), params_.shape.cap_height() - depth_[env]};
  engine_.state->place_prop(env, cap_, pos, mjcf::kCapQuat.data());
}

}  // namespace engram::tasks
