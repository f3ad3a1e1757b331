#include "mjcf/object_descriptor.h"

#include <Eigen/Dense>
#include <algorithm>

namespace engram::mjcf {
namespace {

// The bounding box of a mesh, along its own axes, m.
Eigen::AlignedBox3d bounds_of(const Geom& mesh) {
  Eigen::AlignedBox3d box;
  for (const Vec3& corner : mesh.corners) {
    box.extend(Eigen::Vector3d(corner[0], corner[1], corner[2]));
  }
  return box;
}

// Half sides of the bounding box of a geom, along its own axes, m.
Eigen::Vector3d half_sides(const Geom& geom) {
  const Vec3& size = geom.size;
  switch (geom.type) {
    case GeomType::kBox:
    case GeomType::kEllipsoid:
      return {size[0], size[1], size[2]};
    case GeomType::kSphere:
      return {size[0], size[0], size[0]};
    case GeomType::kCapsule:
      return {size[0], size[0], size[0] + size[1]};
    case GeomType::kCylinder:
      return {size[0], size[0], size[1]};
    case GeomType::kMesh:
      return bounds_of(geom).sizes() / 2;
  }
  return {};
}

}  // namespace

ObjectDescriptor describe_object(const Prop& prop) {
  ObjectDescriptor descriptor{prop.kind, prop.object_shape};
  descriptor.rest_height = prop.pos[2];
  descriptor.travel = prop.travel;
  Eigen::Vector3d low = Eigen::Vector3d::Constant(1e9);
  Eigen::Vector3d high = -low;
  double largest = 0;
  for (const Geom& geom : prop.geoms) {
    if (!geom.visible || geom.hidden_from_sensors) continue;
    const Eigen::Vector3d half = half_sides(geom);
    const Quat& q = geom.quat;
    const Eigen::Matrix3d axes = Eigen::Quaterniond(q[0], q[1], q[2], q[3]).toRotationMatrix();
    const Eigen::Vector3d extent = axes.cwiseAbs() * half;
    Eigen::Vector3d pos(geom.pos[0], geom.pos[1], geom.pos[2]);
    if (geom.type == GeomType::kMesh) pos += axes * bounds_of(geom).center();
    low = low.cwiseMin(pos - extent);
    high = high.cwiseMax(pos + extent);
    if (half.prod() <= largest) continue;
    largest = half.prod();
    descriptor.color = nearest_object_color(geom.rgba[0], geom.rgba[1], geom.rgba[2]);
  }
  // Invisible to sensors.
  if (largest == 0) descriptor.kind = ObjectKind::kPart;
  const Eigen::Vector3d half = (high - low) / 2;
  for (int i = 0; i < 3; ++i) descriptor.half_size[static_cast<std::size_t>(i)] = half[i];
  return descriptor;
}

}  // namespace engram::mjcf
