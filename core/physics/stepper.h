// Computes substeps: poses the bodies, finds the scene that has everything that could touch,
// applies weights, and has the robot and the props moved.
#pragma once

#include <vector>

#include "core/base/step_clock.h"
#include "core/physics/composed_step.h"
#include "core/physics/drive.h"
#include "core/physics/loader.h"
#include "core/physics/pair_sieve.h"
#include "core/physics/robot_bounds.h"
#include "core/physics/robot_step.h"
#include "core/physics/waker.h"

namespace engram {

class Stepper {
 public:
  // Working memory of one thread.
  struct Workbench {
    explicit Workbench(const PhysicsModel& model);

    std::vector<PairSieve> sieves;  // for every compiled scene
    StepBench bench;
  };

  // `clearance`: of the environment's robot, as the last step left it. `clock` may be null.
  Stepper(Workbench& workbench, Loader& loader, Waker& waker, RobotBounds::Clearance& clearance,
          const Drive& drive, StepClock::Worker* clock)
      : model_(loader.model()),
        workbench_(workbench),
        loader_(loader),
        waker_(waker),
        clearance_(clearance),
        robot_(model_.robot_law(), drive),
        clock_(clock) {}

  // The scene to begin a step in. After Waker::begin.
  int first_scene();

  // One substep on the smallest scene that will do. Returns false if MuJoCo warns. `first`: of this
  // control step.
  bool composed_substep(bool first);

  // One substep on the present scene, with a look at every contact pair.
  bool plain_substep();

 private:
  void pose_bodies();
  // Changes to the scene that has everything that the robot or an awake prop could touch.
  void find_scene(bool first);
  // Whether the robot is so far from everything that it needs no geometry.
  bool robot_is_clear();

  StepModels models(const mjModel* colliding) const;
  // Of awake props, at their centres of mass. The robot is weightless.
  void apply_weights() const;
  void limit_spins() const;
  bool warned() const;

  const PhysicsModel& model_;
  Workbench& workbench_;
  Loader& loader_;
  Waker& waker_;
  RobotBounds::Clearance& clearance_;
  RobotStep robot_;
  StepClock::Worker* clock_;
};

}  // namespace engram
