// One physics step from MuJoCo's public stages, with a law of our own for the robot's joints.
//  * Free props move as in mj_step with what contacts.h and sliding.h do in between, bit for bit.
//  * The robot moves by RobotStep. Where nothing touches it, MuJoCo has no part in that. Where
//    something does, MuJoCo's solver finds the forces of contact: for the acceleration that the
//    robot would have without them, and for the inertia that they meet.
// Left out are
//  * what these scenes do not have: sensors, cameras, lights, energy;
//  * what they do not use: actuators, tendons, a second factor of the same matrix;
//  * the checks of the state, which Loader makes.
#pragma once

#include <mujoco/mujoco.h>

#include <span>

#include "core/physics/contacts.h"
#include "core/physics/robot_step.h"

namespace engram {

// The models that the stages of a step work on. They share everything but what is named here.
struct StepModels {
  const mjModel* scene;
  const mjModel* colliding;  // has the contact pairs to look at (see pair_sieve.h)
  const mjModel* solving;    // its inertia matrix has room for what couples the fingers
};

// Throws Error unless the composed step can do the model: the robot's joints first, one coordinate
// each; no constraints but contacts and the limits of free props' neighbours.
void require_composable(const mjModel& model);

// Poses bodies and geoms from qpos.
inline void compose_kinematics(const mjModel* m, mjData* d) { mj_kinematics(m, d); }

// The rest of the step, from the poses that compose_kinematics left.
void compose_dynamics(const StepModels& models, mjData* d, RobotStep& robot,
                      std::span<const Glider> gliders = {});

}  // namespace engram
