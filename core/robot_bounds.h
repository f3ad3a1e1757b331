// A cheap proof that the robot touches nothing: one capsule around the collision geometry of each
// of its bodies.
#pragma once

#include <mujoco/mujoco.h>

#include <Eigen/Dense>
#include <span>
#include <utility>
#include <vector>

namespace engram {

class RobotBounds {
 public:
  // Most bodies of a robot.
  static constexpr std::size_t kMaxBodies = 16;

  // A sphere that the robot may come near.
  struct Obstacle {
    Eigen::Vector3d center;  // m, world
    double radius = 0;
  };

  RobotBounds() = default;
  // Capsules and the pairs of them that matter, from the contact pairs of the robot's scene and of
  // the whole one.
  RobotBounds(const mjModel& robot, const mjModel& whole);

  // True only if, with bodies posed as in `data`, no contact of the robot is possible: with itself,
  // the table top (z = 0) or an obstacle. Needs body poses only, no geometry.
  bool is_clear(const mjData& data, std::span<const Obstacle> obstacles) const;

 private:
  struct Capsule {
    int body = 0;
    Eigen::Vector3d a;  // ends of the axis, body frame
    Eigen::Vector3d b;
    double radius = 0;
    double ball_radius = 0;  // of the ball around it
    bool meets_table = false;
    bool meets_props = false;
  };

  int index_of_body(int body) const;
  void add_capsule(const mjModel& robot, int body);

  std::vector<Capsule> capsules_;
  std::vector<std::pair<int, int>> pairs_;
};

}  // namespace engram
