#include "core/contact/contact_step.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "core/base/index.h"
#include "core/contact/coulomb_sliding.h"
#include "core/math/dense.h"

namespace engram {
namespace {

// Largest difference of the joint solver's velocities from the contact solver's with which the
// former are taken.
constexpr double kArmTolerance = 0.02;      // rad/s
constexpr double kFingerTolerance = 0.005;  // m/s
// Share of a drive's limit up to which its response to a change of force is linear.
constexpr double kLinearShare = 0.9;

// --- unconstrained accelerations ---

void accelerate_props(const SceneModel& scene, mjData& data) {
  for (std::size_t slot = 0; slot < scene.slots.size(); ++slot) {
    const int dof = scene.slots[slot].dof;
    if (scene.free_bodies[slot].is_idle(data)) {
      std::fill_n(data.qacc_smooth + dof, FreeBody::kSize, 0.0);
      std::fill_n(data.qfrc_smooth + dof, FreeBody::kSize, 0.0);
    } else {
      scene.free_bodies[slot].accelerate(data);
    }
  }
}

// --- one island ---

// Range of a dynamic body's velocities in MuJoCo's arrays.
struct DofRange {
  int dof;
  int count;
};
DofRange dofs_of(const SceneModel& scene, int body) {
  if (body == kRobotBody) return {0, kRobotJoints};
  return {scene.slots[at(body - 1)].dof, kPropWidth};
}

// `robot_mass`: effective inertia of the robot; null if it is not in the island.
void gather_island(const SceneModel& scene, const mjData& data, int island,
                   const double* robot_mass, ContactWorkspace& workspace) {
  workspace.bodies.clear();
  double* mass = workspace.masses.data();
  for (const int body : workspace.islands.bodies(island)) {
    const int begin = workspace.islands.begin_of(body);
    const int width = body == kRobotBody ? kRobotWidth : kPropWidth;
    const DofRange dofs = dofs_of(scene, body);
    const auto gather = [&](const mjtNum* from, std::vector<double>& to) {
      std::copy_n(from + dofs.dof, dofs.count, &to[at(begin)]);
      std::fill_n(&to[at(begin)] + dofs.count, width - dofs.count, 0.0);
    };
    gather(data.qfrc_smooth, workspace.smooth_force);
    gather(data.qacc_smooth, workspace.smooth);
    gather(data.qacc_warmstart, workspace.start);
    if (body == kRobotBody) {
      workspace.bodies.push_back({robot_mass, begin, width});
    } else {
      workspace.bodies.push_back({mass, begin, width});
      const FreeBody::MassMatrix matrix = scene.free_bodies[at(body - 1)].mass_matrix(data);
      mass = std::copy(matrix.begin(), matrix.end(), mass);
    }
  }
}

// Sets qacc, qfrc_constraint and the warm start of the island's bodies.
void solve_island(const SceneModel& scene, mjData& data, int island, const double* robot_mass,
                  ContactWorkspace& workspace) {
  const mjModel& model = *scene.model;
  gather_island(scene, data, island, robot_mass, workspace);
  // The scale is the same in all scenes, except for rounding.
  const auto scale = static_cast<float>(model.stat.meaninertia * model.nv);
  workspace.solver.solve(workspace.bodies, workspace.islands.contacts(island),
                         {workspace.rows.jacobian(), data.efc_D, data.efc_aref, data.efc_force},
                         {scale, model.opt.tolerance, model.opt.iterations},
                         workspace.smooth_force.data(), workspace.smooth.data(),
                         workspace.start.data());
  for (const int body : workspace.islands.bodies(island)) {
    const int begin = workspace.islands.begin_of(body);
    const DofRange dofs = dofs_of(scene, body);
    const auto scatter = [&](const double* from, mjtNum* to) {
      std::copy_n(from + begin, dofs.count, to + dofs.dof);
    };
    scatter(workspace.solver.acceleration(), data.qacc);
    scatter(workspace.solver.acceleration(), data.qacc_warmstart);
    scatter(workspace.solver.contact_force(), data.qfrc_constraint);
  }
}

// --- the robot among contacts ---

// Joint-space matrix in the solver's layout: padded to an even width.
using RobotMatrix = std::array<double, kRobotWidth * kRobotWidth>;
RobotMatrix robot_matrix(const JointMatrix& inertia) {
  RobotMatrix matrix{};
  double* to = matrix.data();
  for (const JointRow& row : inertia) to = std::copy(row.begin(), row.end(), to);
  matrix.back() = 1;
  return matrix;
}

// Solves mass * acceleration = force.
JointArray solve_acceleration(RobotMatrix mass, const JointArray& force) {
  JointArray acceleration{};
  if (force == JointArray{}) return acceleration;
  std::array<double, kRobotWidth> inverse;
  std::array<double, kRobotWidth> x{};
  std::copy(force.begin(), force.end(), x.begin());
  factor(mass.data(), inverse.data(), kRobotWidth);
  solve(mass.data(), inverse.data(), x.data(), kRobotWidth);
  std::copy_n(x.begin(), kRobotJoints, acceleration.begin());
  return acceleration;
}

// Sets the robot's acceleration without contacts and the warm start, from the last run of the joint
// solver, which was with this contact force.
void set_robot_acceleration(const RobotStep& robot, const RobotMatrix& mass,
                            const JointArray& force, double timestep, mjData& data) {
  const JointArray change = solve_acceleration(mass, force);
  std::array<double, kRobotWidth> free{};
  for (std::size_t i = 0; i < kRobotJoints; ++i) {
    free[i] = (robot.end_v()[i] - robot.v[i]) / timestep - change[i];
    data.qacc_smooth[i] = free[i];
    data.qacc_warmstart[i] = free[i] + change[i];
  }
  for (std::size_t i = 0; i < kRobotJoints; ++i) {
    data.qfrc_smooth[i] = dot(&mass[i * kRobotWidth], free.data(), kRobotWidth);
  }
}

// Velocities at the substep's end for which the contact solver found the forces.
JointArray solved_velocity(const mjData& data, const RobotStep& robot, double timestep) {
  JointArray velocity;
  for (std::size_t i = 0; i < kRobotJoints; ++i) {
    velocity[i] = robot.v[i] + timestep * data.qacc[i];
  }
  return velocity;
}

bool agrees(const JointArray& velocity, const JointArray& solved) {
  for (std::size_t i = 0; i < kRobotJoints; ++i) {
    const double tolerance = i < kArmJoints ? kArmTolerance : kFingerTolerance;
    if (!(std::abs(velocity[i] - solved[i]) <= tolerance)) return false;
  }
  return true;
}

// Solves the robot's island and updates its contact force. The contact solver linearizes the
// robot's response at the contact force of the last substep, within the linear range of the drives.
// If the joint solver responds otherwise, because a drive or a joint comes to its limit, the
// contact solver's velocities stand: no body penetrates another.
void solve_robot_island(const SceneModel& scene, mjData& data, int island, RobotStep& robot,
                        JointArray& force, ContactWorkspace& workspace) {
  const double timestep = scene.model->opt.timestep;
  const double linear = kLinearShare * robot.force_limit();
  for (double& value : force) value = std::clamp(value, -linear, linear);
  robot.run(force);
  const RobotMatrix mass = robot_matrix(robot.effective_mass_matrix());
  set_robot_acceleration(robot, mass, force, timestep, data);
  solve_island(scene, data, island, mass.data(), workspace);
  std::copy_n(data.qfrc_constraint, kRobotJoints, force.begin());
  robot.run(force);
  if (force != JointArray{}) {
    const JointArray solved = solved_velocity(data, robot, timestep);
    robot.integrate_constant_velocity(agrees(robot.end_v(), solved) ? robot.end_v() : solved);
  }
}

// --- stages ---

// Collision detection, contact constraints and islands.
void find_contacts(const StepModels& models, mjData& data, ContactWorkspace& workspace,
                   std::span<const KinematicBody> kinematic_bodies) {
  const SceneModel& scene = *models.scene;
  mj_collision(models.colliding, &data);
  filter_contacts(*scene.model, data);
  workspace.rows.build(scene, data, kinematic_bodies);
  apply_coulomb_sliding(scene, data, workspace.rows);
  workspace.islands.find(workspace.rows, static_cast<int>(scene.slots.size()) + 1);
}

// Sets the accelerations of all props, and the robot's motion and contact force.
void solve_contacts(const SceneModel& scene, mjData& data, RobotStep& robot,
                    JointArray& contact_force, ContactWorkspace& workspace) {
  bool robot_touches = false;
  for (int island = 0; island < workspace.islands.count(); ++island) {
    if (workspace.islands.holds_robot(island)) {
      robot_touches = true;
      solve_robot_island(scene, data, island, robot, contact_force, workspace);
    } else {
      solve_island(scene, data, island, nullptr, workspace);
    }
  }
  if (!robot_touches) contact_force = {};
}

void move_props(const SceneModel& scene, mjData& data, const ContactWorkspace& workspace) {
  for (std::size_t slot = 0; slot < scene.slots.size(); ++slot) {
    const FreeBody& body = scene.free_bodies[slot];
    if (workspace.rows.contacts_of(static_cast<int>(slot) + 1) == 0) {
      const int dof = scene.slots[slot].dof;
      std::copy_n(data.qacc_smooth + dof, FreeBody::kSize, data.qacc + dof);
      std::copy_n(data.qacc_smooth + dof, FreeBody::kSize, data.qacc_warmstart + dof);
      std::fill_n(data.qfrc_constraint + dof, FreeBody::kSize, 0.0);
      if (body.is_idle(data)) continue;
    }
    body.integrate(data, scene.model->opt.timestep);
  }
}

}  // namespace

ContactWorkspace::ContactWorkspace(std::span<const SceneModel> scenes)
    : rows(scenes),
      islands(rows.max_bodies(), rows.max_contacts()),
      solver(kRobotWidth + kPropWidth * (rows.max_bodies() - 1), rows.max_contacts(),
             rows.max_rows()) {
  const int props = rows.max_bodies() - 1;
  bodies.reserve(at(rows.max_bodies()));
  masses.resize(at(props * kPropWidth * kPropWidth));
  for (std::vector<double>* vector : {&smooth_force, &smooth, &start}) {
    vector->resize(at(kRobotWidth + props * kPropWidth));
  }
}

void contact_step(const StepModels& models, mjData* d, RobotStep& robot, JointArray& contact_force,
                  ContactWorkspace& workspace, std::span<const KinematicBody> kinematic_bodies) {
  const SceneModel& scene = *models.scene;
  accelerate_props(scene, *d);
  find_contacts(models, *d, workspace, kinematic_bodies);
  solve_contacts(scene, *d, robot, contact_force, workspace);
  move_props(scene, *d, workspace);
  std::copy_n(robot.end_q().begin(), kRobotJoints, d->qpos);
  std::copy_n(robot.end_v().begin(), kRobotJoints, d->qvel);
  d->time += scene.model->opt.timestep;
}

}  // namespace engram
