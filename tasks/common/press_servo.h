// Waypoints that press a button, for experts.
#pragma once

#include <Eigen/Dense>

#include "tasks/common/press_button.h"

namespace engram::tasks {

// Height of the TCP that presses for certain; still clear of the sunken cap, m.
double pressing_height(const PressButton& button);

// Next waypoint of a press: over the button at `travel_height`, or higher where the button demands
// it, down until the press begins, then up until it counts.
Eigen::Vector3d press_waypoint(const PressButton& button, int env, double travel_height);

}  // namespace engram::tasks
