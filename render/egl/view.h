// Draw list of one image from an environment's rows: instances, their detail, and the viewpoint.
#pragma once

#include <Eigen/Dense>
#include <cstdint>
#include <vector>

#include "core/image/renderer.h"
#include "render/egl/gl_shapes.h"

namespace engram::gl {

struct Instance {
  float row[3][4];
  float scale[4];
  float color[4];        // rgb, emission
  std::int32_t kind[2];  // segment, surface
};

// Instances of one part, all with patterns or all without.
struct DrawCall {
  int part;
  bool patterned;
  int first;
  int count;
};

// A camera's or light's view of the world.
struct Viewpoint {
  Eigen::Matrix4f clip_from_world;
  // Cameras: what culling and tessellation need.
  Eigen::Vector3f position;
  Eigen::Matrix3f axes;    // columns: right, up, backward
  float slope_x, slope_y;  // tangents of the half angles
  float near_clip, far_clip;
  float pixels;  // size on the screen of 1 m at 1 m
};

// Rows of images run from the top, so y is flipped. That also turns the triangles' order round.
Viewpoint camera_viewpoint(const RenderScene& scene, const RenderInstances& rows, int camera,
                           int width, int height);

// The instances to draw, grouped by part, patterned ones last. Allocates when constructed only.
class DrawList {
 public:
  DrawList(const RenderScene& scene, const Shapes& shapes);

  void fill_for_camera(const RenderInstances& rows, const Viewpoint& view, float tolerance);
  void fill_for_light(const RenderInstances& rows);
  // A cube around everything that casts shadows, viewed along the light. `width` is its side.
  Viewpoint light_viewpoint(const RenderInstances& rows, const Eigen::Vector3f& to_light,
                            float& width) const;

  const std::vector<Instance>& instances() const { return instances_; }
  const std::vector<DrawCall>& draws() const { return draws_; }

 private:
  int level_of(std::size_t geom, const float* pose, const Viewpoint& view, float tolerance) const;
  int group_of(std::size_t geom, int level) const;
  void sort_out(const RenderInstances& rows, const Viewpoint* view);

  const RenderScene& scene_;
  const Shapes& shapes_;
  std::vector<Eigen::Vector3f> half_;  // of each geom: half extents of the box around it
  std::vector<int> group_;  // of each geom: part, or number of parts + part; -1: not drawn
  std::vector<int> begin_;  // of each group
  std::vector<Instance> instances_;
  std::vector<DrawCall> draws_;
};

}  // namespace engram::gl
