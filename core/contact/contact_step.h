// One physics step: MuJoCo finds the contacts, and contacts are of its model (contact_rows.h,
// cone_solver.h); what moves obeys laws of our own.
//  * Free props move by the equations of Newton and Euler, as in mj_step (free_body.h).
//  * The robot moves by RobotStep. Where nothing touches it, that is all. Where something does, the
//    forces of contact are found for the acceleration that it would have without them, and for the
//    inertia that they meet.
//  * What touches one another is solved together, everything else apart (islands.h).
// The checks of the state are SceneBinding's.
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
  const mjModel* colliding;  // has the contact pairs to look at (see pair_sieve.h)
};

// Working memory of one thread, with room for the largest of some scenes.
struct ContactWorkspace {
  explicit ContactWorkspace(std::span<const SceneModel> scenes);

  ContactConstraints rows;
  Islands islands;
  ConeSolver solver;
  // Of the island that is being solved; numbers are those of its movers' velocities.
  std::vector<ConeBody> bodies;
  std::vector<double> masses;  // of the props, matrices
  std::vector<double> smooth_force;
  std::vector<double> smooth;
  std::vector<double> start;
};

// The rest of the step, from poses of bodies and geoms. `robot` knows how the robot moves if
// nothing touches it, and is told what becomes of it.
void contact_step(const StepModels& models, mjData* d, RobotStep& robot, ContactWorkspace& bench,
                  std::span<const KinematicBody> gliders = {});

}  // namespace engram
