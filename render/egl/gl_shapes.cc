#include "render/egl/gl_shapes.h"

#include <Eigen/Dense>
#include <cmath>
#include <numbers>

namespace engram::gl {
namespace {

constexpr double kPi = std::numbers::pi;

// Order of parts: three round shapes with their levels, then box, plane, meshes.
constexpr int kBallParts = 0;
constexpr int kCapsuleParts = kLevels;
constexpr int kCylinderParts = 2 * kLevels;
constexpr int kBoxPart = 3 * kLevels;
constexpr int kPlanePart = kBoxPart + 1;
constexpr int kMeshParts = kBoxPart + 2;

// Radius of the regular polygon with the unit circle's area: its outline is outside of the circle
// as much as inside.
double fair_radius(int slices) {
  return std::sqrt(2 * kPi / (slices * std::sin(2 * kPi / slices)));
}

Vertex make_vertex(double x, double y, double z, double end, double nx, double ny, double nz) {
  return {{static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)},
          static_cast<float>(end),
          {static_cast<float>(nx), static_cast<float>(ny), static_cast<float>(nz)}};
}

}  // namespace

int level_for(float radius_pixels, float tolerance) {
  // The corners of that polygon are outside of the circle by pi^2 / 3 n^2 of the radius.
  const float slices =
      std::numbers::pi_v<float> * std::sqrt(std::max(radius_pixels, 0.0F) / (3 * tolerance));
  int level = 0;
  while (level < kLevels - 1 &&
         static_cast<float>(kSlices[static_cast<std::size_t>(level)]) < slices) {
    ++level;
  }
  return level;
}

Shapes::Shapes(const std::vector<RenderMesh>& meshes) {
  for (const int slices : kSlices) add_ball(slices, 0);
  for (const int slices : kSlices) add_ball(slices, 1);
  for (const int slices : kSlices) add_cylinder(slices);
  add_box();
  add_plane();
  for (const RenderMesh& mesh : meshes) add_mesh(mesh);
}

int Shapes::part_of(const RenderGeom& geom, int level) const {
  switch (geom.shape) {
    case RenderShape::kSphere:
    case RenderShape::kEllipsoid:
      return kBallParts + level;
    case RenderShape::kCapsule:
      return kCapsuleParts + level;
    case RenderShape::kCylinder:
      return kCylinderParts + level;
    case RenderShape::kBox:
      return kBoxPart;
    case RenderShape::kPlane:
      return kPlanePart;
    case RenderShape::kMesh:
      return kMeshParts + geom.mesh;
  }
  return kBoxPart;
}

void Shapes::begin() {
  parts_.push_back({static_cast<std::uint32_t>(indices_.size()), 0,
                    static_cast<std::int32_t>(vertices_.size())});
}

std::uint32_t Shapes::add(const Vertex& vertex) {
  vertices_.push_back(vertex);
  return static_cast<std::uint32_t>(vertices_.size() - 1) -
         static_cast<std::uint32_t>(parts_.back().first_vertex);
}

void Shapes::add_triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
  indices_.insert(indices_.end(), {a, b, c});
  parts_.back().index_count += 3;
}

// Rings from the top down; with stretch 1 the equator is there twice, once for each end.
void Shapes::add_ball(int slices, float stretch) {
  begin();
  const double radius = fair_radius(slices);
  const int stacks = slices / 2;
  std::vector<std::uint32_t> above;
  for (int stack = 0; stack <= stacks; ++stack) {
    const double polar = kPi * stack / stacks;
    const int copies = stretch > 0 && 2 * stack == stacks ? 2 : 1;
    for (int copy = 0; copy < copies; ++copy) {
      const bool upper = 2 * stack < stacks || (copies == 2 && copy == 0);
      std::vector<std::uint32_t> ring;
      for (int i = 0; i < slices; ++i) {
        const double angle = 2 * kPi * i / slices;
        const double x = std::sin(polar) * std::cos(angle);
        const double y = std::sin(polar) * std::sin(angle);
        const double z = std::cos(polar);
        ring.push_back(add(
            make_vertex(radius * x, radius * y, radius * z, upper ? stretch : -stretch, x, y, z)));
      }
      for (std::size_t i = 0; i < above.size(); ++i) {
        const std::size_t next = (i + 1) % ring.size();
        if (stack != stacks) add_triangle(above[i], ring[i], ring[next]);
        if (stack != 1) add_triangle(above[i], ring[next], above[next]);
      }
      above = ring;
    }
  }
}

void Shapes::add_cylinder(int slices) {
  begin();
  const double radius = fair_radius(slices);
  std::vector<std::uint32_t> side[2];
  std::vector<std::uint32_t> cap[2];
  for (int i = 0; i < slices; ++i) {
    const double angle = 2 * kPi * i / slices;
    const double x = std::cos(angle);
    const double y = std::sin(angle);
    for (int top = 0; top < 2; ++top) {
      const double z = top == 1 ? 1 : -1;
      side[top].push_back(add(make_vertex(radius * x, radius * y, z, 0, x, y, 0)));
      cap[top].push_back(add(make_vertex(radius * x, radius * y, z, 0, 0, 0, z)));
    }
  }
  for (std::size_t i = 0; i < side[0].size(); ++i) {
    const std::size_t next = (i + 1) % side[0].size();
    add_triangle(side[0][i], side[0][next], side[1][next]);
    add_triangle(side[0][i], side[1][next], side[1][i]);
    if (next > 1) {
      add_triangle(cap[1][0], cap[1][i], cap[1][next]);
      add_triangle(cap[0][0], cap[0][next], cap[0][i]);
    }
  }
}

void Shapes::add_box() {
  begin();
  for (int axis = 0; axis < 3; ++axis) {
    const int u = (axis + 1) % 3;
    const int v = (axis + 2) % 3;
    for (const float sign : {1.0F, -1.0F}) {
      std::uint32_t corner[4];
      for (int i = 0; i < 4; ++i) {
        Vertex vertex = {};
        vertex.position[axis] = sign;
        vertex.position[u] = (i == 1 || i == 2 ? 1.0F : -1.0F) * sign;
        vertex.position[v] = i >= 2 ? 1.0F : -1.0F;
        vertex.normal[axis] = sign;
        corner[i] = add(vertex);
      }
      add_triangle(corner[0], corner[1], corner[2]);
      add_triangle(corner[0], corner[2], corner[3]);
    }
  }
}

void Shapes::add_plane() {
  begin();
  std::uint32_t corner[4];
  for (int i = 0; i < 4; ++i) {
    corner[i] = add(make_vertex(i == 1 || i == 2 ? 1 : -1, i >= 2 ? 1 : -1, 0, 0, 0, 0, 1));
  }
  add_triangle(corner[0], corner[1], corner[2]);
  add_triangle(corner[0], corner[2], corner[3]);
}

void Shapes::add_mesh(const RenderMesh& mesh) {
  begin();
  for (std::size_t t = 0; t + 2 < mesh.triangles.size(); t += 3) {
    Eigen::Vector3f point[3];
    for (std::size_t k = 0; k < 3; ++k) {
      point[k] = Eigen::Map<const Eigen::Vector3f>(
          &mesh.vertices[3 * static_cast<std::size_t>(mesh.triangles[t + k])]);
    }
    const Eigen::Vector3f normal = (point[1] - point[0]).cross(point[2] - point[0]).normalized();
    std::uint32_t corner[3];
    for (int k = 0; k < 3; ++k) {
      corner[k] = add(make_vertex(point[k].x(), point[k].y(), point[k].z(), 0, normal.x(),
                                  normal.y(), normal.z()));
    }
    add_triangle(corner[0], corner[1], corner[2]);
  }
}

}  // namespace engram::gl
