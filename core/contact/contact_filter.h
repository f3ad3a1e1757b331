// Contact filter between MuJoCo's collision detection and the contact constraints: false contacts,
// speculative contacts and depenetration.
#pragma once

#include <mujoco/mujoco.h>

#include <Eigen/Dense>
#include <span>

#include "core/scene/free_body.h"

namespace engram {

// A kinematic body in motion.
struct KinematicBody {
  int mocap = 0;
  Eigen::Vector3d velocity;  // m/s
};

// Called between mj_collision and ContactConstraints::build:
//  * Drops false contacts.
//  * Makes contacts within their pair's gap speculative: they stop an approaching body where it
//    touches, without friction. Otherwise it would penetrate before there is any contact.
//  * Depenetrates objects that have appeared around the fingers.
void filter_contacts(const mjModel& model, mjData& data);

}  // namespace engram
