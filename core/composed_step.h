// One physics step from MuJoCo's public stages: what mj_step does, less what these scenes do not
// have (sensors, cameras, lights, energy) and less the state checks, which the engine makes itself.
#pragma once

#include <mujoco/mujoco.h>

namespace engram {

// Everything that follows from qpos alone up to where bodies are.
inline void compose_kinematics(const mjModel* m, mjData* d) { mj_kinematics(m, d); }

// The rest of the step, from the poses that compose_kinematics left. `colliding` is the model with
// the contact pairs to look at (see pair_sieve.h).
inline void compose_dynamics(const mjModel* m, mjData* d, const mjModel* colliding) {
  // position: inertia, contacts, constraint rows
  mj_comPos(m, d);
  mj_tendon(m, d);
  mj_crb(m, d);
  mj_factorM(m, d);
  mj_collision(colliding, d);
  mj_makeConstraint(m, d);
  mj_transmission(m, d);
  mj_projectConstraint(m, d);
  // velocity, forces, acceleration
  mj_fwdVelocity(m, d);
  mj_fwdActuation(m, d);
  mj_fwdAcceleration(m, d);
  mj_fwdConstraint(m, d);
  // integration
  mj_Euler(m, d);
}

}  // namespace engram
