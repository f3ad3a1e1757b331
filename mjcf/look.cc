#include <Eigen/Dense>
#include <algorithm>

#include "mjcf/prop.h"

namespace engram::mjcf {
namespace {

// Half sides of the box around a primitive, along its own axes, m.
Eigen::Vector3d half_sides(const Primitive& primitive) {
  const Vec3& size = primitive.size;
  switch (primitive.shape) {
    case Shape::kBox:
    case Shape::kEllipsoid:
      return {size[0], size[1], size[2]};
    case Shape::kSphere:
      return {size[0], size[0], size[0]};
    case Shape::kCapsule:
      return {size[0], size[0], size[0] + size[1]};
    case Shape::kCylinder:
      return {size[0], size[0], size[1]};
  }
  return {};
}

}  // namespace

ObjectDescriptor look_of(const Prop& prop) {
  ObjectDescriptor look{prop.kind, prop.object_shape};
  look.rest_height = prop.pos[2];
  look.travel = prop.travel;
  Eigen::Vector3d low = Eigen::Vector3d::Constant(1e9);
  Eigen::Vector3d high = -low;
  double largest = 0;
  for (const Primitive& primitive : prop.primitives) {
    if (!primitive.visible || primitive.hidden_from_sensors) continue;
    const Eigen::Vector3d half = half_sides(primitive);
    const Quat& q = primitive.quat;
    const Eigen::Matrix3d axes = Eigen::Quaterniond(q[0], q[1], q[2], q[3]).toRotationMatrix();
    const Eigen::Vector3d reach = axes.cwiseAbs() * half;
    const Eigen::Vector3d pos(primitive.pos[0], primitive.pos[1], primitive.pos[2]);
    low = low.cwiseMin(pos - reach);
    high = high.cwiseMax(pos + reach);
    if (half.prod() <= largest) continue;
    largest = half.prod();
    look.color = nearest_object_color(primitive.rgba[0], primitive.rgba[1], primitive.rgba[2]);
  }
  // Nothing that sensors see.
  if (largest == 0) look.kind = ObjectKind::kPart;
  const Eigen::Vector3d half = (high - low) / 2;
  for (int i = 0; i < 3; ++i) look.half_size[static_cast<std::size_t>(i)] = half[i];
  return look;
}

}  // namespace engram::mjcf
