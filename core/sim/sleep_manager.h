// Decides which props wake and which fall asleep, from how near things are to one another. See
// proximity.h for the measures of nearness.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/scene/proximity.h"
#include "core/scene/robot_bounds.h"
#include "core/sim/scene_binding.h"

namespace engram {

class SleepManager {
 public:
  // Working memory of one environment on its way through a step; one entry per prop, but for
  // obstacles.
  struct Workspace {
    explicit Workspace(const PhysicsModel& model);

    std::vector<Frame> frames;              // world
    std::vector<std::uint8_t> frame_known;  // frames of resting props are made when first needed
    std::vector<Eigen::Vector3d> centers;   // of bounding spheres, world
    std::vector<double> beyond;  // m, how far a sleeping prop is at least from the robot's reach
    std::vector<RobotBounds::Obstacle> obstacles;
  };

  SleepManager(Workspace& workspace, SceneBinding& loader)
      : model_(loader.model()),
        workspace_(workspace),
        loader_(loader),
        state_(loader.state()),
        env_(loader.env()) {}

  // Finds where props are, and wakes those that a gliding prop will come near. After
  // SceneBinding::begin.
  void begin();

  // What the robot could touch: spheres around tangible props that were at rest or glide.
  const std::vector<RobotBounds::Obstacle>& obstacles() const { return workspace_.obstacles; }

  // Wakes sleeping props that the robot or an awake prop could touch, and changes to a scene that
  // has them; one with the kinematic props, too, if any of them could be touched. True if the scene
  // changed: it has to be loaded and posed before the next call. `qpos`: of the robot.
  bool wake_touching(const JointArray& qpos);

  // Puts props to sleep that have rested long enough beside nothing that moves. After
  // SceneBinding::store.
  void sleep_resting();

 private:
  int num_props() const { return loader_.num_props(); }
  const PropModel& prop_model(int prop) const { return loader_.prop_model(prop); }

  // --- where things are ---

  void locate(int prop, const double* pos, const double* quat);
  // Where the columns have a prop.
  void locate_remembered(int prop);
  // Gliding props by spheres around their whole ways.
  void locate_gliding();
  // Where awake props are in the present scene.
  void locate_awake();
  const Frame& frame_of(int prop) const;
  // Radius of the sphere that a prop does not leave during this step.
  double reach_of(int prop) const;

  // --- the robot's reach ---

  // Lowest height that a part of the robot may reach: a cheap first test, since props lie low and
  // the robot is above them most of the time.
  double lowest_reach() const;
  // A distance, m, that a prop has at least from where the robot would wake it; not above zero if
  // the robot wakes it.
  double robot_beyond(int prop, double lowest) const;
  // Whether the robot is where it wakes a sleeping prop. `lowest` is found when first needed.
  bool robot_reaches(int prop, std::optional<double>& lowest);

  // --- props near one another ---

  bool props_near(int prop, int other) const;
  bool awake_prop_near(int prop) const;
  // Whether a gliding prop comes near a free one.
  bool gliding_near(int prop) const;
  void wake_beside_gliding();

  // --- sleep ---

  // Counts for how many control steps awake props have been at rest.
  void count_slow_steps(std::uint8_t* slow) const;
  // Awake props near one another count as slow as long as the most restless of them, so that they
  // fall asleep together: one that stayed awake would wake the others. True if a count changed.
  bool share_slow_steps(std::uint8_t* slow) const;

  const PhysicsModel& model_;
  Workspace& workspace_;
  SceneBinding& loader_;
  const State& state_;
  int env_;
  JointArray seen_qpos_{};  // when sleeping props were looked at
};

}  // namespace engram
