// A scene checked and prepared for the ray caster; read-only, shared by all workers.
#pragma once

#include <Eigen/Dense>
#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "core/image/renderer.h"
#include "render/cpu/cpu_options.h"
#include "render/cpu/frame_data.h"

namespace engram::cpu {

// A convex mesh as the planes around it: normal . p <= offset.
struct Hull {
  std::vector<Eigen::Vector3d> normals;
  std::vector<double> offsets;
  Eigen::Vector3d center;  // of its bounding box
  Eigen::Vector3d half;    // half extents of that
};

struct PreparedScene {
  // Throws Error.
  PreparedScene(const RenderScene& from, const CpuRendererOptions& options);

  bool casts_shadows() const;

  RenderScene scene;
  std::vector<Hull> hulls;                         // one per mesh
  std::vector<Eigen::Vector3d> to_light;           // unit, one per light
  std::vector<std::vector<Eigen::Vector3d>> rays;  // unit, towards each light; empty: no shadow
  double shadow_softness = 0;                      // half angle of the cone that they fill, rad
  WoodTexture wood = {};                           // if any geom needs it
  std::size_t max_planes = 0;                      // of all geoms together
  std::size_t max_surfaces = 0;                    // the background included
  std::size_t max_glosses = 0;
  // Geoms that are projected in batches of one shape, and those that are projected alone.
  std::vector<int> boxes;
  std::vector<int> capsules;
  std::vector<int> cylinders;
  std::vector<int> others;
  // Radius of the ball around each geom, and a little more; planes and meshes are in none.
  std::vector<double> ball_radius;
  std::vector<float> rank_radius;  // and exactly, of boxes, capsules and cylinders
};

// Fills `directions` with some that are spread evenly over the cone around `axis`.
void spread(const Eigen::Vector3d& axis, double half_angle, std::span<Eigen::Vector3d> directions);

// Throws Error if the mesh is not convex or not closed. `name` is for messages.
Hull make_hull(const RenderMesh& mesh, const std::string& name);

}  // namespace engram::cpu
