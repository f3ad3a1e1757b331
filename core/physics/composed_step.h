// One physics step from MuJoCo's public stages. The results are those of mj_step, bit for bit.
// Left out are
//  * what these scenes do not have: sensors, cameras, lights, energy;
//  * what they do not use: actuators' lengths and velocities, a second factor of the same matrix;
//  * the checks of the state, which Loader makes.
#pragma once

#include <mujoco/mujoco.h>

namespace engram {

// Throws Error unless the composed step can do the model: motors of gain one, each on the joint of
// its own index; no damped tendon; no constraints but contacts and the limits of hinges and slides;
// joint damping too small to change a bit.
void require_composable(const mjModel& model);

// Poses bodies and geoms from qpos.
inline void compose_kinematics(const mjModel* m, mjData* d) { mj_kinematics(m, d); }

// The rest of the step, from the poses that compose_kinematics left. `colliding` is the model with
// the contact pairs to look at (see pair_sieve.h).
void compose_dynamics(const mjModel* m, mjData* d, const mjModel* colliding);

}  // namespace engram
