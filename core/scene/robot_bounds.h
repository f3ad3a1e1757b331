// A cheap proof that the robot touches nothing: one capsule around the collision geometry of each
// of its bodies.
#pragma once

#include <mujoco/mujoco.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <span>
#include <utility>
#include <vector>

#include "core/robot/robot_pose.h"

namespace engram {

class RobotBounds {
 public:
  static constexpr std::size_t kMaxBodies = 16;

  // A sphere that the robot may come near.
  struct Obstacle {
    Eigen::Vector3d center;  // m, world
    double radius = 0;
  };

  // Lower bounds of the robot's distances to what it could touch, m. If both are above zero, it
  // touches nothing.
  struct Clearance {
    double own = 0;     // between its own bodies, and to the table top (z = 0)
    double around = 0;  // to obstacles
    double lowest = 0;  // height of the parts that may meet obstacles; valid if `own` is above zero
    JointArray qpos{};  // at which this was found
    // How far any part of the robot may move from there before it could touch something, m.
    double room() const { return std::min(own, around); }
    bool is_clear() const { return room() > 0; }
  };

  RobotBounds() = default;
  // Takes from the contact pairs of both scenes which bodies need a capsule, and which pairs of
  // capsules matter.
  RobotBounds(const mjModel& robot, const mjModel& whole);

  Clearance clearance(const RobotPose& pose, std::span<const Obstacle> obstacles) const;
  // The same clearance among other obstacles. Compares heights only.
  static Clearance among(const Clearance& before, std::span<const Obstacle> obstacles);
  // Of each joint: most that a point of the robot moves per rad or m.
  const JointArray& arms() const { return arms_; }
  // Most that a point of the robot can have moved between joint positions, m: the joints' turns
  // times the longest arms that they have.
  double way(const JointArray& from, const JointArray& to) const;
  // True only if the robot cannot have touched anything on its way from before.qpos. The obstacles
  // must be the same.
  bool still_clear(const Clearance& before, const JointArray& qpos) const;

 private:
  struct Capsule {
    int body = 0;
    int link = -1;      // that carries it; -1: none does
    Eigen::Vector3d a;  // ends of the axis, in the link's frame
    Eigen::Vector3d b;
    double radius = 0;
    double ball_radius = 0;  // of the ball around it
    bool meets_table = false;
    bool meets_props = false;
  };

  // Where capsules are in the world.
  struct Placed {
    std::array<Eigen::Vector3d, kMaxBodies> a;
    std::array<Eigen::Vector3d, kMaxBodies> b;
    std::array<Eigen::Vector3d, kMaxBodies> middle;
  };

  int index_of_body(int body) const;
  void measure_arms(const mjModel& robot);
  double self_clearance(const Placed& placed) const;
  double obstacle_clearance(const Placed& placed, std::span<const Obstacle> obstacles,
                            double lowest) const;
  void add_capsule(const mjModel& robot, int body);

  std::vector<Capsule> capsules_;
  std::vector<std::pair<int, int>> pairs_;
  JointArray arms_{};
};

}  // namespace engram
