// Sleep of props: decides which props wake and which fall asleep, by lower bounds of distances
// (proximity.h).
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/robot/robot_pose.h"
#include "core/scene/proximity.h"
#include "core/scene/robot_bounds.h"
#include "core/sim/env_step.h"

namespace engram {

// Working memory of one environment's step; one entry per prop, except obstacles.
struct SleepWorkspace {
  explicit SleepWorkspace(const PhysicsModel& model);

  std::vector<Frame> frames;              // world
  std::vector<std::uint8_t> frame_known;  // frames of resting props are computed on demand
  std::vector<Eigen::Vector3d> centers;   // of bounding spheres, world
  std::vector<double>
      clearance;  // m, lower bound of a sleeping prop's distance to the robot's reach
  std::vector<double> approach;  // m, of any point of an awake prop in a substep, at most
  std::vector<RobotBounds::Obstacle> obstacles;
};

class SleepManager {
 public:
  SleepManager(EnvStep& step, SleepWorkspace& workspace)
      : step_(step), workspace_(workspace), state_(step.state), env_(step.env) {}

  // Locates props, and wakes those that a moving kinematic prop will come near. Call it after
  // StateTransfer::begin. `substeps`: of the control step.
  void begin(int substeps);

  // Bounding spheres of tangible props that were at rest or are kinematic: what the robot can
  // touch.
  const std::vector<RobotBounds::Obstacle>& obstacles() const { return workspace_.obstacles; }

  // Wakes sleeping props that the robot or an awake prop may touch, and those that these may touch.
  // Wakes nothing else than free props. Call it after StateTransfer::pose_links.
  void wake_touching(const RobotPose& robot);

  // Counts the control steps for which awake props have been at rest, near nothing that moves. Call
  // it before StateTransfer::store.
  void count_slow_steps();
  // Puts props to sleep that have rested long enough. Call it after StateTransfer::store.
  void sleep_resting();

 private:
  int num_props() const { return step_.num_props(); }
  const PropModel& prop_model(int prop) const { return step_.prop_model(prop); }

  // --- positions of props ---

  // Locates a prop by the columns.
  void locate_stored(int prop);
  // Locates moving kinematic props by spheres around their whole displacement.
  void locate_moving();
  // Locates awake props by their present motion.
  void locate_awake();
  const Frame& frame_of(int prop) const;
  // Displacement of a moving kinematic prop in this control step, m.
  Eigen::Map<const Eigen::Vector3d> displacement(int prop) const;
  // Radius of the sphere that a prop does not leave during this step.
  double swept_radius(int prop) const;

  // --- distances to the robot ---

  // Computes the poses of the robot's reach, if they are not known.
  void pose_reach();
  // Lowest height that a part of the robot may reach: a cheap first test, since props lie low and
  // the robot is above them most of the time.
  double lowest_reach() const;
  // Below which parts of the robot wake a prop: the largest, or what follows from their speeds.
  enum class Gaps { kLargest, kBySpeed };
  // Lower bound of a prop's distance to the robot's reach, less the gap, m. Looks at the parts from
  // `first` on, up to one that is too near, of which `first` is then the index.
  double robot_clearance(int prop, double lowest, Gaps gaps, std::size_t& first) const;
  // Tests whether the robot wakes a sleeping prop. `lowest` is computed on demand.
  bool robot_reaches(int prop, std::optional<double>& lowest);

  // --- distances between props ---

  bool props_near(int prop, int other, double gap) const;
  bool awake_prop_near(int prop) const;
  // Tests for a moving kinematic prop near a free one.
  bool moving_prop_near(int prop) const;
  void wake_near_moving_props();

  // --- sleep ---

  // Tests an awake prop's speed, or how far it has come in this control step.
  bool is_slow(int prop) const;
  // Lowers the counts of awake props near one another to the least of them, so that they fall
  // asleep together: one that stayed awake would wake the others. True if a count changed.
  bool share_slow_steps(std::uint8_t* slow) const;

  EnvStep& step_;
  SleepWorkspace& workspace_;
  const State& state_;
  int env_;
  JointArray checked_qpos_{};  // at the last wake_touching
  bool reach_known_ = false;   // since then
};

}  // namespace engram
