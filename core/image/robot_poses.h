// Poses of all robot bodies from joint positions, for pictures.
#pragma once

#include <mujoco/mujoco.h>

#include <Eigen/Dense>
#include <span>
#include <string>
#include <vector>

#include "core/image/image_source.h"

namespace engram {

class RobotPoses {
 public:
  // The tree of a robot's model; every body has at most one joint, a hinge or a slide.
  explicit RobotPoses(const mjModel& robot);

  // Names of the bodies, parents first.
  const std::vector<std::string>& names() const { return names_; }
  // Writes the pose of each body for qpos; `out` has names().size() elements.
  void compute(const double* qpos, std::span<BodyView> out) const;

 private:
  struct Body {
    int parent;  // index here, or -1 for the world
    Eigen::Vector3d pos;
    Eigen::Quaterniond quat;
    int qpos = -1;  // address of its joint's coordinate, or -1
    bool slides = false;
    Eigen::Vector3d axis;
  };
  std::vector<std::string> names_;
  std::vector<Body> bodies_;
};

}  // namespace engram
