// How near a sphere is to a collision geom: decides when sleeping props wake.
#pragma once

#include <mujoco/mujoco.h>

#include <Eigen/Dense>

namespace engram {

// True if the sphere may touch the geom, posed as `data` says. Exact for boxes, capsules and
// spheres; never misses a touch for any other shape.
bool sphere_reaches_geom(const mjModel& model, const mjData& data, int geom,
                         const Eigen::Vector3d& center, double radius);

}  // namespace engram
