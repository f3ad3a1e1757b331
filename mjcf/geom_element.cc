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
  if (rpy != Vec3{}) set(geom, "euler", rpy);
  return geom;
}

Element& add_fromto_geom(Element& body, GeomType type, const Vec3& from, const Vec3& to,
                         double radius) {
  Element& geom = add(body, "geom");
  set(geom, "type", geom_type(type));
  set(geom, "size", radius);
  set(geom, "fromto", {from[0], from[1], from[2], to[0], to[1], to[2]});
  return geom;
}

}  // namespace engram::mjcf
