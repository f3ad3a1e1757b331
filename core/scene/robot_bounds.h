// Bounding capsules of the robot: a cheap proof that it touches nothing. One capsule encloses the
// collision geometry of each of its bodies.
#pragma once

#include <mujoco/mujoco.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <compare>
#include <span>
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

  // Lower bounds of the robot's distances to what it could touch, m. If all are above zero, it
  // touches nothing.
  struct Clearance {
    // Between its own bodies: the least distance of two that only this joint and later ones move
    // against one another.
    JointArray self{};
    double table = 0;      // to the table top (z = 0)
    double obstacles = 0;  // to obstacles
    double lowest = 0;     // height of the parts that may meet obstacles; valid if `table` is above
                           // zero
    JointArray qpos{};     // joint positions of this measurement
    // To all that is not the robot.
    double outside() const { return std::min(table, obstacles); }
    bool is_clear() const {
      return outside() > 0 && *std::min_element(self.begin(), self.end()) > 0;
    }
  };

  RobotBounds() = default;
  // Reads from the contact pairs of both scenes which bodies need a capsule, and which pairs of
  // capsules can touch.
  RobotBounds(const mjModel& robot, const mjModel& whole);

  Clearance clearance(const RobotPose& pose, std::span<const Obstacle> obstacles) const;
  // Updates a clearance for other obstacles. Compares heights only.
  static Clearance with_obstacles(const Clearance& before, std::span<const Obstacle> obstacles);
  // Largest displacement of a point of the robot per rad or m of each joint.
  const JointArray& lever_arms() const { return lever_arms_; }
  // Bound of the displacement of any point of the robot between joint positions, m: the joints'
  // changes times their lever arms.
  double max_displacement(const JointArray& from, const JointArray& to) const;

 private:
  struct Capsule {
    int body = 0;
    int link = -1;      // index of the joint that moves it, or -1
    Eigen::Vector3d a;  // ends of the axis, in the link's frame
    Eigen::Vector3d b;
    double radius = 0;
    double bounding_radius = 0;  // of the bounding sphere
    bool meets_table = false;
    bool meets_props = false;
  };

  // World positions of the capsules' ends and middles.
  struct CapsulePositions {
    std::array<Eigen::Vector3d, kMaxBodies> a;
    std::array<Eigen::Vector3d, kMaxBodies> b;
    std::array<Eigen::Vector3d, kMaxBodies> middle;
  };

  // Capsules that can touch.
  struct Pair {
    int first = 0;
    int second = 0;
    int joint = 0;  // the first that moves one against the other

    // clang-tidy 14 takes the zero in what this is made of for a null pointer.
    auto operator<=>(const Pair&) const = default;  // NOLINT(modernize-use-nullptr)
  };

  int index_of_body(int body) const;
  void find_lever_arms(const mjModel& robot);
  JointArray self_clearance(const CapsulePositions& positions) const;
  Pair pair_of(int capsule, int other) const;
  double obstacle_clearance(const CapsulePositions& positions, std::span<const Obstacle> obstacles,
                            double lowest) const;
  void add_capsule(const mjModel& robot, int body);

  std::vector<Capsule> capsules_;
  std::vector<Pair> pairs_;
  JointArray lever_arms_{};
};

}  // namespace engram
