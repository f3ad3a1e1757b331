#include "tasks/common/press_servo.h"

#include <algorithm>

namespace engram::tasks {

double pressing_height(const PressButton& button) {
  constexpr double kBelowFullTravel = 0.004;  // m
  const PressButtonParams& params = button.params();
  return params.zone_height() - params.BUTTON_CAP_TRAVEL - kBelowFullTravel;
}

Eigen::Vector3d press_waypoint(const PressButton& button, int env, double travel_height) {
  constexpr double kOverhead = 0.03;  // m: near enough to the centre to come down
  constexpr double kClear = 0.02;     // m above where a press begins, or ends
  const PressButtonParams& params = button.params();
  double height = std::max(travel_height, params.zone_height() + kClear);
  if (button.pending(env)) {
    height = std::max(button.lift_target(env), params.release_height() + kClear);
  } else if (button.ready(env) && button.distance(env) < kOverhead) {
    height = pressing_height(button);
  }
  const Vec2 xy = button.center(env);
  return {xy.x(), xy.y(), height};
}

}  // namespace engram::tasks
