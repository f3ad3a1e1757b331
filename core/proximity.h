// How near things are to one another: decides when sleeping props wake.
#pragma once

#include <mujoco/mujoco.h>

#include <Eigen/Dense>
#include <span>

namespace engram {

// True if the sphere may touch the geom, posed as `data` says. Exact for boxes, capsules and
// spheres; never misses a touch for any other shape.
bool sphere_reaches_geom(const mjModel& model, const mjData& data, int geom,
                         const Eigen::Vector3d& center, double radius);

// Position and axes (columns) of a body or a geom.
struct Frame {
  Eigen::Vector3d pos = Eigen::Vector3d::Zero();
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();
};
Frame make_frame(const double* pos, const double* quat);
Frame geom_frame(const mjData& data, int geom);

// All points within `radius` of a box: contains a geom, tightly if it is a box, a sphere or a
// capsule.
struct RoundedBox {
  Frame frame;  // in the body's
  Eigen::Vector3d half = Eigen::Vector3d::Zero();
  double radius = 0;

  // Of a ball around it.
  double ball_radius() const { return half.norm() + radius; }
};
RoundedBox enclose_geom(const mjModel& model, int geom);

// False only if every part of one body is farther than `gap` from every part of the other.
bool parts_near(std::span<const RoundedBox> a, const Frame& frame_a, std::span<const RoundedBox> b,
                const Frame& frame_b, double gap);

}  // namespace engram
