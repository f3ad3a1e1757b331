// Computes what lanes do not: an environment's substeps near things that the robot could touch, or
// with props that move. Poses the bodies, finds the scene that has everything that could touch,
// applies weights, and has props and contacts computed.
#pragma once

#include "core/base/step_clock.h"
#include "core/contact/contact_step.h"
#include "core/robot/lane_block.h"
#include "core/robot/robot_params.h"
#include "core/robot/robot_step.h"
#include "core/scene/robot_bounds.h"
#include "core/sim/scene_binding.h"
#include "core/sim/sleep_manager.h"

namespace engram {

class Stepper {
 public:
  // `clearance`: of the environment's robot, as the last step left it. `clock` may be null.
  Stepper(SceneBinding& loader, SleepManager& waker, RobotBounds::Clearance& clearance,
          const DriveTarget& drive, StepClock::Worker* clock)
      : model_(loader.model()),
        loader_(loader),
        waker_(waker),
        clearance_(clearance),
        robot_(model_.robot_params(), drive),
        clock_(clock) {}

  // The scene to begin a step in. After SleepManager::begin.
  int first_scene();

  // Whether there is anything to compute beside the robot's free motion.
  bool is_busy() const { return loader_.scene_index() != PhysicsModel::kDynamicsScene; }

  // Looks again, for a robot that has come to this pose, whether it is still clear of everything.
  // If not, it will be busy from now on.
  void look_around(const RobotPose& pose);

  // What the present substep is beside the robot's free motion: the lane holds that, with details,
  // and is told its end if something touches the robot. On the smallest scene that will do; without
  // `sleep` on the present scene, with a look at every contact pair. Returns false if MuJoCo warns.
  bool substep(const RobotPose& pose, bool sleep, LaneBlock& block, int lane);

  const RobotBounds::Clearance& clearance() const { return clearance_; }

 private:
  void load(const RobotPose& pose);
  // Of awake props, at their centres of mass. The robot is weightless.
  void apply_weights() const;
  void limit_spins() const;
  bool warned() const;

  const PhysicsModel& model_;
  SceneBinding& loader_;
  SleepManager& waker_;
  RobotBounds::Clearance& clearance_;
  RobotStep robot_;
  StepClock::Worker* clock_;
  bool looked_ = false;  // around, in this step
};

}  // namespace engram
