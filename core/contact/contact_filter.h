// What becomes of the contacts that MuJoCo finds, before and after it makes constraint rows of
// them.
#pragma once

#include <mujoco/mujoco.h>

#include <Eigen/Dense>
#include <span>

#include "core/scene/free_body.h"

namespace engram {

// A kinematic body on its way.
struct KinematicBody {
  int mocap = 0;
  Eigen::Vector3d velocity;  // m/s
};

// Between mj_collision and ContactConstraints::build:
//  * Drops contacts that are none.
//  * Lets those act that are still apart, within their pair's gap: they stop what comes just where
//    it touches, without friction. Otherwise it would be inside before there is a contact at all.
//  * Pushes objects out that have appeared around the fingers.
void filter_contacts(const mjModel& model, mjData& data);

}  // namespace engram
