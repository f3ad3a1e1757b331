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

// Between mj_collision and mj_makeConstraint:
//  * Drops contacts that are none.
//  * Lets those act that are still apart, within their pair's gap: they stop what comes just where
//    it touches, without friction. Otherwise it would be inside before there is a contact at all.
//  * Pushes objects out that have appeared around the fingers. Needs mj_comVel.
void refine_contacts(const mjModel& model, mjData& data);

// MuJoCo takes kinematic bodies to stand still. Makes contacts meet them at their velocities. After
// mj_referenceConstraint.
void meet_gliders(const mjModel& model, mjData& data, std::span<const Glider> gliders);

}  // namespace engram
