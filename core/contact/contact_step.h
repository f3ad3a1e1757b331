// One physics substep: MuJoCo detects collisions, and contacts follow its model
// (contact_constraints.h, cone_solver.h); integration is the engine's own.
//  * Free props obey the Newton-Euler equations, as in mj_step (free_body.h).
//  * The robot moves by RobotStep. If something touches it, contact forces are found for the
//    acceleration that it would have without them and for its effective inertia.
//  * Bodies that touch one another are solved together, by islands (islands.h).
// SceneBinding checks the state.
#pragma once

#include <mujoco/mujoco.h>

#include <span>
#include <vector>

#include "core/contact/cone_solver.h"
#include "core/contact/contact_constraints.h"
#include "core/contact/contact_filter.h"
#include "core/contact/islands.h"
#include "core/robot/robot_step.h"
#include "core/scene/scene_model.h"

namespace engram {

struct StepModels {
  const SceneModel* scene;
  const mjModel* colliding;  // with the pairs that may touch (broad_phase.h)
};

// Working memory of one thread, allocated for the largest of some scenes.
struct ContactWorkspace {
  explicit ContactWorkspace(std::span<const SceneModel> scenes);

  ContactConstraints rows;
  Islands islands;
  ConeSolver solver;
  // Input of the solver for one island, in the order of its bodies' velocities.
  std::vector<ConeBody> bodies;
  std::vector<double> masses;  // mass matrices of props
  std::vector<double> smooth_force;
  std::vector<double> smooth;
  std::vector<double> start;
};

// Steps robot and props, given the poses of bodies and geoms. `robot` holds the robot's motion
// without contacts, and afterwards its motion with them. `contact_force`: on the robot's joints, N
// m, N; from the last substep, and afterwards of this one.
void contact_step(const StepModels& models, mjData* d, RobotStep& robot, JointArray& contact_force,
                  ContactWorkspace& workspace,
                  std::span<const KinematicBody> kinematic_bodies = {});

}  // namespace engram
