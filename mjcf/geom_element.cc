#include "mjcf/geom_element.h"

#include <span>

namespace engram::mjcf {

const char* geom_type(GeomType type) {
  switch (type) {
    case GeomType::kBox:
      return "box";
    case GeomType::kSphere:
      return "sphere";
    case GeomType::kCapsule:
      return "capsule";
    case GeomType::kCylinder:
      return "cylinder";
    case GeomType::kEllipsoid:
      return "ellipsoid";
    case GeomType::kMesh:
      return "mesh";
  }
  return "box";
}

int size_count(GeomType type) {
  switch (type) {
    case GeomType::kSphere:
      return 1;
    case GeomType::kCapsule:
    case GeomType::kCylinder:
      return 2;
    case GeomType::kBox:
    case GeomType::kEllipsoid:
      return 3;
    case GeomType::kMesh:
      return 0;
  }
  return 3;
}

Element& add_geom(Element& body, GeomType type, const Vec3& size, const Vec3& pos,
                  const Vec3& rpy) {
  Element& geom = add(body, "geom");
  set(geom, "type", geom_type(type));
  const int sizes = size_count(type);
  if (sizes > 0) set(geom, "size", std::span(size).first(static_cast<std::size_t>(sizes)));
  set(geom, "pos", pos);
  set_rotation(geom, rpy);
  return geom;
}

Element& add_fromto_geom(Element& body, GeomType type, const Vec3& from, const Vec3& to,
                         double radius) {
  const Eigen::Vector3d start = Eigen::Vector3d::Map(from.data());
  const Eigen::Vector3d end = Eigen::Vector3d::Map(to.data());
  const Eigen::Vector3d middle = (start + end) / 2;
  const Eigen::Vector3d axis = (start - end).normalized();  // z of the geom
  Element& geom = add(body, "geom");
  set(geom, "type", geom_type(type));
  set(geom, "size", {radius, (start - end).norm() / 2});
  set(geom, "pos", {middle[0], middle[1], middle[2]});
  const bool opposite = axis.z() < -1 + 1e-12;
  set_rotation(geom, opposite ? Eigen::Quaterniond(0, 1, 0, 0)
                              : Eigen::Quaterniond(1 + axis.z(), -axis.y(), axis.x(), 0));
  return geom;
}

}  // namespace engram::mjcf
