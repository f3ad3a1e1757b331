// How near things are to one another: decides when sleeping props wake.
#pragma once

#include <mujoco/mujoco.h>

#include <Eigen/Dense>
#include <span>

namespace engram {

// Farther than anything in a scene.
inline constexpr double kFarAway = 1e9;  // m

// A distance, m, that the sphere has at least from the geom, posed as `data` says; above zero only
// if they do not touch. Not above zero only if they touch, for boxes, capsules and spheres.
double sphere_to_geom(const mjModel& model, const mjData& data, int geom,
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

// By how much, m, every part of one body is at least farther than `gap` from every part of the
// other; not above zero where one may be as near as that.
double parts_beyond(double gap, std::span<const RoundedBox> a, const Frame& frame_a,
                    std::span<const RoundedBox> b, const Frame& frame_b);

}  // namespace engram
