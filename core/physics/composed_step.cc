#include "core/physics/composed_step.h"

#include <algorithm>
#include <cstddef>
#include <string>

#include "core/base/error.h"

namespace engram {
namespace {

// Whether a joint is where its limit makes a constraint row.
bool limit_reached(const mjModel* m, const mjData* d) {
  for (int i = 0; i < m->njnt; ++i) {
    if (m->jnt_limited[i] == 0) continue;
    const mjtNum value = d->qpos[m->jnt_qposadr[i]];
    const mjtNum* range = m->jnt_range + 2 * static_cast<std::ptrdiff_t>(i);
    const mjtNum margin = m->jnt_margin[i];
    if (value - range[0] < margin || range[1] - value < margin) return true;
  }
  return false;
}

// Inertia, contacts, constraint rows. Only contacts and limits make rows (require_composable).
// Without rows there is nothing to project.
void compose_position(const mjModel* m, mjData* d, const mjModel* colliding) {
  mj_comPos(m, d);
  mj_tendon(m, d);
  mj_crb(m, d);
  mj_factorM(m, d);
  mj_collision(colliding, d);
  if (d->ncon > 0 || limit_reached(m, d)) {
    mj_makeConstraint(m, d);
  } else {
    d->ne = d->nf = d->nefc = 0;
  }
  if (d->nefc > 0) mj_projectConstraint(m, d);
}

// mj_fwdVelocity without the velocities of tendons and actuators: no force depends on them.
void compose_velocity(const mjModel* m, mjData* d) {
  mj_comVel(m, d);
  mj_passive(m, d);
  mj_referenceConstraint(m, d);
  mj_rne(m, d, 0, d->qfrc_bias);
}

// mj_fwdActuation and mj_fwdAcceleration for motors whose force is their control, without forces
// on bodies.
void compose_forces(const mjModel* m, mjData* d) {
  for (int i = 0; i < m->nu; ++i) d->qfrc_actuator[i] = 0.0 + d->ctrl[i];  // no negative zero
  mju_sub(d->qfrc_smooth, d->qfrc_passive, d->qfrc_bias, m->nv);
  mju_addTo(d->qfrc_smooth, d->qfrc_applied, m->nv);
  mju_addTo(d->qfrc_smooth, d->qfrc_actuator, m->nv);
  mj_solveM(m, d, d->qacc_smooth, d->qfrc_smooth, 1);
}

// Whether a free prop is damped. The robot's damping changes no bit (scene_model.cc).
bool has_damped_props(const mjModel* m) {
  return std::any_of(m->dof_damping + m->nu, m->dof_damping + m->nv,
                     [](mjtNum damping) { return damping != 0; });
}

// mj_Euler solves for the acceleration again, from the forces and with the damping in the matrix.
// If the damping does not change the matrix, its factor is at hand. If there are no constraint rows
// either, so is the acceleration.
void compose_integration(const mjModel* m, mjData* d) {
  if (has_damped_props(m)) {
    mj_Euler(m, d);
    return;
  }
  mjMARKSTACK const mjtNum* acceleration = d->qacc_smooth;
  if (d->nefc > 0) {
    mjtNum* solved = mj_stackAlloc(d, m->nv);
    mju_add(solved, d->qfrc_smooth, d->qfrc_constraint, m->nv);
    mj_solveM(m, d, solved, solved, 1);
    acceleration = solved;
  }
  mju_addToScl(d->qvel, acceleration, m->opt.timestep, m->nv);
  mj_integratePos(m, d->qpos, d->qvel, m->opt.timestep);
  mju_copy(d->qacc_warmstart, d->qacc, m->nv);
  d->time += m->opt.timestep;
  mjFREESTACK
}

}  // namespace

void require_composable(const mjModel& model) {
  const auto refuse = [](const char* why) {
    throw Error(Error::kInternal, std::string("scene that cannot be stepped: ") + why);
  };
  for (int i = 0; i < model.nu; ++i) {
    const bool plain =
        model.actuator_trntype[i] == mjTRN_JOINT && model.actuator_trnid[2 * i] == i &&
        model.jnt_dofadr[i] == i && model.actuator_gear[6 * i] == 1 &&
        model.actuator_gainprm[i * mjNGAIN] == 1 && model.actuator_biastype[i] == mjBIAS_NONE;
    if (!plain) refuse("an actuator is not a motor of gain one on the joint of its index");
  }
  if (model.neq > 0) refuse("there are equality constraints");
  for (int i = 0; i < model.nv; ++i) {
    if (model.dof_frictionloss[i] != 0) refuse("a joint has friction");
  }
  for (int i = 0; i < model.njnt; ++i) {
    const int type = model.jnt_type[i];
    if (model.jnt_limited[i] != 0 && type != mjJNT_HINGE && type != mjJNT_SLIDE) {
      refuse("a limited joint neither turns nor slides");
    }
  }
  for (int i = 0; i < model.ntendon; ++i) {
    if (model.tendon_damping[i] != 0 || model.tendon_limited[i] != 0 ||
        model.tendon_frictionloss[i] != 0) {
      refuse("a tendon depends on its velocity");
    }
  }
}

void compose_dynamics(const mjModel* m, mjData* d, const mjModel* colliding) {
  compose_position(m, d, colliding);
  compose_velocity(m, d);
  compose_forces(m, d);
  mj_fwdConstraint(m, d);
  compose_integration(m, d);
}

}  // namespace engram
