#include "core/physics/composed_step.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>

#include "core/base/error.h"
#include "core/physics/sliding.h"

namespace engram {
namespace {

// How near the law's answer has to be to the solver's to be taken.
constexpr double kArmTolerance = 0.02;      // rad/s
constexpr double kFingerTolerance = 0.005;  // m/s
// Of a drive's limit: up to here it answers to a change of force as the solver takes it to.
constexpr double kBearable = 0.9;

bool has_props(const mjModel* m) { return m->nv > kRobotJoints; }

// Inertia, contacts, constraint rows; the bodies' velocities, which contacts depend on. Only
// contacts make rows (require_composable). The Newton solver does not need them projected.
void compose_position(const StepModels& models, mjData* d) {
  const mjModel* m = models.scene;
  mj_comPos(m, d);
  mj_comVel(m, d);
  mj_crb(m, d);
  if (has_props(m)) mj_factorM(m, d);
  mj_collision(models.colliding, d);
  refine_contacts(*m, *d);
  if (d->ncon > 0) {
    mj_makeConstraint(m, d);
  } else {
    d->ne = d->nf = d->nefc = 0;
  }
}

void compose_velocity(const mjModel* m, mjData* d, std::span<const Glider> gliders) {
  if (has_props(m)) mj_passive(m, d);
  mj_referenceConstraint(m, d);
  meet_gliders(*m, *d, gliders);
  mj_rne(m, d, 0, d->qfrc_bias);
}

// Of the props; without forces on bodies. The robot's part means nothing yet.
void compose_forces(const mjModel* m, mjData* d) {
  if (!has_props(m)) return;
  mju_sub(d->qfrc_smooth, d->qfrc_passive, d->qfrc_bias, m->nv);
  mju_addTo(d->qfrc_smooth, d->qfrc_applied, m->nv);
  mj_solveM(m, d, d->qacc_smooth, d->qfrc_smooth, 1);
}

// --- the robot ---

// Calls visit(row, column, entry of qM) for the robot's part of the inertia matrix.
template <class Visit>
void visit_robot_inertia(const mjModel* m, mjData* d, const Visit& visit) {
  for (int row = 0; row < kRobotJoints; ++row) {
    mjtNum* entry = d->qM + m->dof_Madr[row];
    for (int column = row; column >= 0; column = m->dof_parentid[column]) {
      visit(static_cast<std::size_t>(row), static_cast<std::size_t>(column), *entry++);
    }
  }
}

// As if nothing touched it.
void move_robot(const mjModel* m, mjData* d, RobotStep& robot) {
  std::copy_n(d->qpos, kRobotJoints, robot.q.begin());
  std::copy_n(d->qvel, kRobotJoints, robot.v.begin());
  std::copy_n(d->qfrc_bias, kRobotJoints, robot.bias.begin());
  visit_robot_inertia(m, d, [&](std::size_t row, std::size_t column, const mjtNum& entry) {
    robot.inertia[row][column] = robot.inertia[column][row] = entry;
  });
  robot.prepare();
  robot.run({});
}

// The forces of contacts on the robot's joints travel from substep to substep where MuJoCo has the
// robot's part of its warm start.
JointArray last_contact_force(const mjData* d) {
  JointArray force;
  std::copy_n(d->qacc_warmstart, kRobotJoints, force.begin());
  return force;
}
void keep_contact_force(mjData* d, const JointArray& force) {
  std::copy_n(force.begin(), kRobotJoints, d->qacc_warmstart);
}

bool robot_is_touched(const mjModel* m, const mjData* d) {
  const int last_link = m->dof_bodyid[kRobotJoints - 1];
  const auto of_robot = [&](int geom) {
    return m->geom_bodyid[geom] > 0 && m->geom_bodyid[geom] <= last_link;
  };
  return std::any_of(d->contact, d->contact + d->ncon, [&](const mjContact& contact) {
    return contact.efc_address >= 0 && (of_robot(contact.geom1) || of_robot(contact.geom2));
  });
}

// Tells the solver how the robot would accelerate without contacts, and what resists them, by the
// last run of the robot, which was with this force of contacts.
void describe_robot(const StepModels& models, mjData* d, const RobotStep& robot,
                    const JointArray& force) {
  const JointMatrix inertia = robot.effective_inertia();
  const JointMatrix mobility = inverse(inertia);
  visit_robot_inertia(models.solving, d, [&](std::size_t row, std::size_t column, mjtNum& entry) {
    entry = inertia[row][column];
  });
  JointArray change{};  // by the force
  for (std::size_t i = 0; i < kRobotJoints; ++i) {
    for (std::size_t j = 0; j < kRobotJoints; ++j) change[i] += mobility[i][j] * force[j];
  }
  JointArray free{};
  for (std::size_t i = 0; i < kRobotJoints; ++i) {
    free[i] = (robot.end_v()[i] - robot.v[i]) / models.scene->opt.timestep - change[i];
    d->qacc_smooth[i] = free[i];
    d->qacc_warmstart[i] = free[i] + change[i];
  }
  for (std::size_t i = 0; i < kRobotJoints; ++i) {
    d->qfrc_smooth[i] = 0;
    for (std::size_t j = 0; j < kRobotJoints; ++j) d->qfrc_smooth[i] += inertia[i][j] * free[j];
  }
}

// For a robot that nothing touches.
void leave_out_robot(mjData* d) {
  std::fill_n(d->qacc_smooth, kRobotJoints, 0.0);
  std::fill_n(d->qfrc_smooth, kRobotJoints, 0.0);
  std::fill_n(d->qacc_warmstart, kRobotJoints, 0.0);
}

// The velocities at the substep's end for which the solver found the forces.
JointArray foreseen_velocity(const mjModel* m, const mjData* d, const RobotStep& robot) {
  JointArray velocity;
  for (std::size_t i = 0; i < kRobotJoints; ++i) {
    velocity[i] = robot.v[i] + m->opt.timestep * d->qacc[i];
  }
  return velocity;
}

bool is_near(const JointArray& velocity, const JointArray& foreseen) {
  for (std::size_t i = 0; i < kRobotJoints; ++i) {
    const double tolerance = i < kArmJoints ? kArmTolerance : kFingerTolerance;
    if (!(std::abs(velocity[i] - foreseen[i]) <= tolerance)) return false;
  }
  return true;
}

void solve_without_contacts(const mjModel* m, mjData* d) {
  if (!has_props(m)) return;
  mju_copy(d->qacc, d->qacc_smooth, m->nv);
  mju_copy(d->qacc_warmstart + kRobotJoints, d->qacc_smooth + kRobotJoints, m->nv - kRobotJoints);
  mju_zero(d->qfrc_constraint, m->nv);
}

// The forces of contacts, and how they change the robot's way. The solver takes the robot's answer
// to a change of force for linear, from the forces of the last substep on, as far as the drives can
// bear them. Where the robot's law answers otherwise, because a drive or a joint comes to its
// limit, the solver is right: nothing gets inside anything.
JointArray solve_contacts(const StepModels& models, mjData* d, RobotStep& robot) {
  JointArray force = last_contact_force(d);
  if (force != JointArray{}) {
    const double bearable = kBearable * robot.force_limit();
    for (double& value : force) value = std::clamp(value, -bearable, bearable);
    robot.run(force);
  }
  describe_robot(models, d, robot, force);
  mj_fwdConstraint(models.solving, d);
  std::copy_n(d->qfrc_constraint, kRobotJoints, force.begin());
  robot.run(force);
  if (force != JointArray{}) {
    const JointArray foreseen = foreseen_velocity(models.scene, d, robot);
    robot.move_evenly(is_near(robot.end_v(), foreseen) ? robot.end_v() : foreseen);
  }
  return force;
}

// Contacts of props alone.
void solve_without_robot(const StepModels& models, mjData* d) {
  leave_out_robot(d);
  mj_fwdConstraint(models.solving, d);
}

// --- the end of the step ---

bool has_damped_props(const mjModel* m) {
  return std::any_of(m->dof_damping + kRobotJoints, m->dof_damping + m->nv,
                     [](mjtNum damping) { return damping != 0; });
}

// As mj_Euler does it. Where there is damping, it goes into the matrix.
void move_props(const StepModels& models, mjData* d) {
  const mjModel* m = models.scene;
  if (has_damped_props(m)) {
    mj_Euler(models.solving, d);
    return;
  }
  mju_addToScl(d->qvel, d->qacc, m->opt.timestep, m->nv);
  mj_integratePos(m, d->qpos, d->qvel, m->opt.timestep);
  d->time += m->opt.timestep;
}

void compose_integration(const StepModels& models, mjData* d) {
  if (has_props(models.scene)) {
    move_props(models, d);
  } else {
    d->time += models.scene->opt.timestep;
  }
}

}  // namespace

void require_composable(const mjModel& model) {
  const auto refuse = [](const char* why) {
    throw Error(Error::kInternal, std::string("scene that cannot be stepped: ") + why);
  };
  for (int i = 0; i < kRobotJoints; ++i) {
    const int type = model.jnt_type[i];
    if (model.jnt_dofadr[i] != i || (type != mjJNT_HINGE && type != mjJNT_SLIDE)) {
      refuse("the robot's nine joints are not its first");
    }
  }
  if (model.neq > 0) refuse("there are equality constraints");
  if (model.opt.solver != mjSOL_NEWTON) refuse("its solver is not Newton's");
  for (int i = 0; i < model.nv; ++i) {
    if (model.dof_frictionloss[i] != 0) refuse("a joint has friction");
  }
  for (int i = 0; i < model.njnt; ++i) {
    if (model.jnt_limited[i] != 0) refuse("a joint has a limit that is a constraint");
  }
  for (int i = 0; i < model.ntendon; ++i) {
    if (model.tendon_stiffness[i] != 0 || model.tendon_damping[i] != 0 ||
        model.tendon_limited[i] != 0 || model.tendon_frictionloss[i] != 0) {
      refuse("a tendon pulls");
    }
  }
}

void compose_dynamics(const StepModels& models, mjData* d, RobotStep& robot,
                      std::span<const Glider> gliders) {
  compose_position(models, d);
  compose_velocity(models.scene, d, gliders);
  compose_forces(models.scene, d);
  slide_freely(*models.scene, *d);
  move_robot(models.scene, d, robot);
  JointArray force{};
  if (d->nefc == 0) {
    solve_without_contacts(models.scene, d);
  } else if (robot_is_touched(models.scene, d)) {
    force = solve_contacts(models, d, robot);
  } else {
    solve_without_robot(models, d);
  }
  keep_contact_force(d, force);
  compose_integration(models, d);
  std::copy_n(robot.end_q().begin(), kRobotJoints, d->qpos);
  std::copy_n(robot.end_v().begin(), kRobotJoints, d->qvel);
}

}  // namespace engram
