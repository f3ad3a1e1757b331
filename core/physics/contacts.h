// What becomes of the contacts that MuJoCo finds, before and after it makes constraint rows of
// them.
#pragma once

#include <mujoco/mujoco.h>

#include <Eigen/Dense>
#include <span>

namespace engram {

// A kinematic body on its way.
struct Glider {
  int mocap = 0;
  Eigen::Vector3d velocity;  // m/s
};

// Whether a body is moved by physics and by no joint of the robot.
bool is_free_body(const mjModel& model, int body);

// Between mj_collision and ContactRows::build:
//  * Drops contacts that are none.
//  * Lets those act that are still apart, within their pair's gap: they stop what comes just where
//    it touches, without friction. Otherwise it would be inside before there is a contact at all.
//  * Pushes objects out that have appeared around the fingers.
void refine_contacts(const mjModel& model, mjData& data);

}  // namespace engram
