// Triangles of the shapes that the OpenGL renderer draws, all in two buffers.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/image/renderer.h"

namespace engram::gl {

// A vertex of a shape of size 1. Its place is position * scale + end * half_length along z.
struct Vertex {
  float position[3];
  float end;  // -1, 0 or 1
  float normal[3];
};

// A run of triangles. Indices count from `first_vertex`.
struct ShapePart {
  std::uint32_t first_index = 0;
  std::uint32_t index_count = 0;
  std::int32_t first_vertex = 0;
};

// Round shapes come in levels, by the corners of their outline: multiples of 4.
inline constexpr std::array kSlices = {8, 12, 16, 24, 32, 48, 64, 96, 128};
inline constexpr int kLevels = static_cast<int>(kSlices.size());

// The coarsest level whose outline is off by at most `tolerance` pixels for that radius.
int level_for(float radius_pixels, float tolerance);

class Shapes {
 public:
  explicit Shapes(const std::vector<RenderMesh>& meshes);

  // Index into parts() of a geom's shape; the level matters for round shapes only.
  int part_of(const RenderGeom& geom, int level) const;
  const std::vector<ShapePart>& parts() const { return parts_; }
  const std::vector<Vertex>& vertices() const { return vertices_; }
  const std::vector<std::uint32_t>& indices() const { return indices_; }

 private:
  void begin();
  std::uint32_t add(const Vertex& vertex);
  void add_triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c);
  void add_ball(int slices, float stretch);
  void add_cylinder(int slices);
  void add_box();
  void add_plane();
  void add_mesh(const RenderMesh& mesh);

  std::vector<ShapePart> parts_;
  std::vector<Vertex> vertices_;
  std::vector<std::uint32_t> indices_;
};

}  // namespace engram::gl
