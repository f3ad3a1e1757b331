// A cheap proof that the robot touches nothing: one capsule around the collision geometry of each
// of its bodies.
#pragma once

#include <mujoco/mujoco.h>

#include <Eigen/Dense>
#include <array>
#include <span>
#include <utility>
#include <vector>

namespace engram {

class RobotBounds {
 public:
  // Most bodies and joints of a robot.
  static constexpr std::size_t kMaxBodies = 16;
  static constexpr std::size_t kMaxJoints = 12;

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
    std::array<double, kMaxJoints> qpos{};  // at which this was found
    bool is_clear() const { return own > 0 && around > 0; }
  };

  RobotBounds() = default;
  // Takes from the contact pairs of both scenes which bodies need a capsule, and which pairs of
  // capsules matter.
  RobotBounds(const mjModel& robot, const mjModel& whole);

  // With bodies posed as in `data`. Needs body poses only, no geometry.
  Clearance clearance(const mjData& data, std::span<const Obstacle> obstacles) const;
  // The same clearance among other obstacles. Compares heights only.
  static Clearance among(const Clearance& before, std::span<const Obstacle> obstacles);
  // Most that a point of the robot can have moved between joint angles `qpos` and data.qpos, m: the
  // joints' turns times the longest arms that they have.
  double way_from(const std::array<double, kMaxJoints>& qpos, const mjData& data) const;
  // True only if the robot cannot have touched anything on its way from before.qpos to data.qpos.
  // The obstacles must be the same.
  bool still_clear(const Clearance& before, const mjData& data) const;

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
  std::vector<double> arms_;  // of each joint: most that a point moves per rad or m
};

}  // namespace engram
