#include "core/contact/contact_step.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <string>

#include "core/base/error.h"
#include "core/contact/coulomb_sliding.h"
#include "core/math/dense.h"

namespace engram {
namespace {

// How near the law's answer has to be to the solver's to be taken.
constexpr double kArmTolerance = 0.02;      // rad/s
constexpr double kFingerTolerance = 0.005;  // m/s
// Of a drive's limit: up to here it answers to a change of force as the solver takes it to.
constexpr double kBearable = 0.9;

std::size_t at(int index) { return static_cast<std::size_t>(index); }

// --- what moves, as if nothing touched it ---

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

// Where MuJoCo has a mover's velocity, and how many numbers it has.
struct Place {
  int dof;
  int count;
};
Place place_of(const SceneModel& scene, int mover) {
  if (mover == kRobotBody) return {0, kRobotJoints};
  return {scene.slots[at(mover - 1)].dof, kPropWidth};
}

// `resisting`: what contacts with the robot meet; null where the island does not hold it.
void gather_island(const SceneModel& scene, const mjData& data, int island, const double* resisting,
                   ContactWorkspace& bench) {
  bench.bodies.clear();
  double* mass = bench.masses.data();
  for (const int mover : bench.islands.movers(island)) {
    const int begin = bench.islands.begin_of(mover);
    const int width = mover == kRobotBody ? kRobotWidth : kPropWidth;
    const Place place = place_of(scene, mover);
    const auto gather = [&](const mjtNum* from, std::vector<double>& to) {
      std::copy_n(from + place.dof, place.count, &to[at(begin)]);
      std::fill_n(&to[at(begin)] + place.count, width - place.count, 0.0);
    };
    gather(data.qfrc_smooth, bench.smooth_force);
    gather(data.qacc_smooth, bench.smooth);
    gather(data.qacc_warmstart, bench.start);
    if (mover == kRobotBody) {
      bench.bodies.push_back({resisting, begin, width});
    } else {
      bench.bodies.push_back({mass, begin, width});
      const FreeBody::MassMatrix matrix = scene.free_bodies[at(mover - 1)].mass_matrix(data);
      mass = std::copy(matrix.begin(), matrix.end(), mass);
    }
  }
}

// Sets qacc, qfrc_constraint and the warm start of the island's movers.
void solve_island(const SceneModel& scene, mjData& data, int island, const double* resisting,
                  ContactWorkspace& bench) {
  const mjModel& model = *scene.model;
  gather_island(scene, data, island, resisting, bench);
  // The same in all scenes, but for rounding.
  const auto scale = static_cast<float>(model.stat.meaninertia * model.nv);
  bench.solver.solve(bench.bodies, bench.islands.contacts(island),
                     {bench.rows.jacobian(), data.efc_D, data.efc_aref, data.efc_force},
                     {scale, model.opt.tolerance, model.opt.iterations}, bench.smooth_force.data(),
                     bench.smooth.data(), bench.start.data());
  for (const int mover : bench.islands.movers(island)) {
    const int begin = bench.islands.begin_of(mover);
    const Place place = place_of(scene, mover);
    const auto scatter = [&](const double* from, mjtNum* to) {
      std::copy_n(from + begin, place.count, to + place.dof);
    };
    scatter(bench.solver.acceleration(), data.qacc);
    scatter(bench.solver.acceleration(), data.qacc_warmstart);
    scatter(bench.solver.contact_force(), data.qfrc_constraint);
  }
}

// --- the robot among contacts ---

// The forces of contacts on the robot's joints travel from substep to substep where MuJoCo has the
// robot's part of its warm start.
JointArray last_contact_force(const mjData& data) {
  JointArray force;
  std::copy_n(data.qacc_warmstart, kRobotJoints, force.begin());
  return force;
}
void keep_contact_force(mjData& data, const JointArray& force) {
  std::copy_n(force.begin(), kRobotJoints, data.qacc_warmstart);
}

// As the solver has it: with a number to spare.
using RobotMatrix = std::array<double, kRobotWidth * kRobotWidth>;
RobotMatrix robot_matrix(const JointMatrix& inertia) {
  RobotMatrix matrix{};
  double* to = matrix.data();
  for (const JointRow& row : inertia) to = std::copy(row.begin(), row.end(), to);
  matrix.back() = 1;
  return matrix;
}

// The acceleration that a force gives.
JointArray answer(RobotMatrix resisting, const JointArray& force) {
  JointArray acceleration{};
  if (force == JointArray{}) return acceleration;
  std::array<double, kRobotWidth> inverse;
  std::array<double, kRobotWidth> x{};
  std::copy(force.begin(), force.end(), x.begin());
  factor(resisting.data(), inverse.data(), kRobotWidth);
  solve(resisting.data(), inverse.data(), x.data(), kRobotWidth);
  std::copy_n(x.begin(), kRobotJoints, acceleration.begin());
  return acceleration;
}

// Tells the solver how the robot would accelerate without contacts, by the last run of the robot,
// which was with this force of contacts. `resisting`: what resists them.
void describe_robot(const RobotStep& robot, const RobotMatrix& resisting, const JointArray& force,
                    double timestep, mjData& data) {
  const JointArray change = answer(resisting, force);
  std::array<double, kRobotWidth> free{};
  for (std::size_t i = 0; i < kRobotJoints; ++i) {
    free[i] = (robot.end_v()[i] - robot.v[i]) / timestep - change[i];
    data.qacc_smooth[i] = free[i];
    data.qacc_warmstart[i] = free[i] + change[i];
  }
  for (std::size_t i = 0; i < kRobotJoints; ++i) {
    data.qfrc_smooth[i] = dot(&resisting[i * kRobotWidth], free.data(), kRobotWidth);
  }
}

// The velocities at the substep's end for which the solver found the forces.
JointArray foreseen_velocity(const mjData& data, const RobotStep& robot, double timestep) {
  JointArray velocity;
  for (std::size_t i = 0; i < kRobotJoints; ++i) {
    velocity[i] = robot.v[i] + timestep * data.qacc[i];
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

// The forces of contacts, and how they change the robot's way. The solver takes the robot's answer
// to a change of force for linear, from the forces of the last substep on, as far as the drives can
// bear them. Where the robot's law answers otherwise, because a drive or a joint comes to its
// limit, the solver is right: nothing gets inside anything.
JointArray solve_robot_island(const SceneModel& scene, mjData& data, int island, RobotStep& robot,
                              ContactWorkspace& bench) {
  const double timestep = scene.model->opt.timestep;
  JointArray force = last_contact_force(data);
  const double bearable = kBearable * robot.force_limit();
  for (double& value : force) value = std::clamp(value, -bearable, bearable);
  robot.run(force);
  const RobotMatrix resisting = robot_matrix(robot.effective_mass_matrix());
  describe_robot(robot, resisting, force, timestep, data);
  solve_island(scene, data, island, resisting.data(), bench);
  std::copy_n(data.qfrc_constraint, kRobotJoints, force.begin());
  robot.run(force);
  if (force != JointArray{}) {
    const JointArray foreseen = foreseen_velocity(data, robot, timestep);
    robot.integrate_constant_velocity(is_near(robot.end_v(), foreseen) ? robot.end_v() : foreseen);
  }
  return force;
}

// --- the stages ---

// Rows of all contacts, and who is solved with whom.
void find_contacts(const StepModels& models, mjData& data, ContactWorkspace& bench,
                   std::span<const KinematicBody> gliders) {
  const SceneModel& scene = *models.scene;
  mj_collision(models.colliding, &data);
  filter_contacts(*scene.model, data);
  bench.rows.build(scene, data, gliders);
  apply_coulomb_sliding(scene, data, bench.rows);
  bench.islands.find(bench.rows, static_cast<int>(scene.slots.size()) + 1);
}

// Sets the accelerations of all props, and the robot's way.
void solve_contacts(const SceneModel& scene, mjData& data, RobotStep& robot,
                    ContactWorkspace& bench) {
  JointArray force{};
  for (int island = 0; island < bench.islands.count(); ++island) {
    if (bench.islands.holds_robot(island)) {
      force = solve_robot_island(scene, data, island, robot, bench);
    } else {
      solve_island(scene, data, island, nullptr, bench);
    }
  }
  keep_contact_force(data, force);
}

void move_props(const SceneModel& scene, mjData& data, const ContactWorkspace& bench) {
  for (std::size_t slot = 0; slot < scene.slots.size(); ++slot) {
    const FreeBody& body = scene.free_bodies[slot];
    if (bench.rows.contacts_of(static_cast<int>(slot) + 1) == 0) {
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
      islands(rows.most_movers(), rows.most_contacts()),
      solver(kRobotWidth + kPropWidth * (rows.most_movers() - 1), rows.most_contacts(),
             rows.most_rows()) {
  const int props = rows.most_movers() - 1;
  bodies.reserve(at(rows.most_movers()));
  masses.resize(at(props * kPropWidth * kPropWidth));
  for (std::vector<double>* vector : {&smooth_force, &smooth, &start}) {
    vector->resize(at(kRobotWidth + props * kPropWidth));
  }
}

void contact_step(const StepModels& models, mjData* d, RobotStep& robot, ContactWorkspace& bench,
                  std::span<const KinematicBody> gliders) {
  const SceneModel& scene = *models.scene;
  accelerate_props(scene, *d);
  find_contacts(models, *d, bench, gliders);
  solve_contacts(scene, *d, robot, bench);
  move_props(scene, *d, bench);
  std::copy_n(robot.end_q().begin(), kRobotJoints, d->qpos);
  std::copy_n(robot.end_v().begin(), kRobotJoints, d->qvel);
  d->time += scene.model->opt.timestep;
}

}  // namespace engram
