// One physics step from MuJoCo's public stages: what mj_step does, bit for bit, less what these
// scenes do not have (sensors, cameras, lights, energy), what they have no use for (actuators'
// lengths and velocities, a second factor of the same matrix) and the state checks, which the
// engine makes itself.
#pragma once

#include <mujoco/mujoco.h>

namespace engram {

// Throws Error unless the model is one that the composed step is made for: motors of gain one, each
// on the joint of its own index, no damped tendon, no constraints but contacts and the limits of
// hinges and slides, and joint damping that changes no bit.
void require_composable(const mjModel& model);

// Everything that follows from qpos alone up to where bodies are.
inline void compose_kinematics(const mjModel* m, mjData* d) { mj_kinematics(m, d); }

// The rest of the step, from the poses that compose_kinematics left. `colliding` is the model with
// the contact pairs to look at (see pair_sieve.h).
void compose_dynamics(const mjModel* m, mjData* d, const mjModel* colliding);

}  // namespace engram
