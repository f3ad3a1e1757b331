#include "mjcf/shape.h"

#include <span>

namespace engram::mjcf {

const char* geom_type(Shape shape) {
  switch (shape) {
    case Shape::kBox:
      return "box";
    case Shape::kSphere:
      return "sphere";
    case Shape::kCapsule:
      return "capsule";
    case Shape::kCylinder:
      return "cylinder";
    case Shape::kEllipsoid:
      return "ellipsoid";
  }
  return "box";
}

int size_count(Shape shape) {
  switch (shape) {
    case Shape::kSphere:
      return 1;
    case Shape::kCapsule:
    case Shape::kCylinder:
      return 2;
    case Shape::kBox:
    case Shape::kEllipsoid:
      return 3;
  }
  return 3;
}

Element& add_geom(Element& body, Shape shape, const Vec3& size, const Vec3& pos, const Vec3& rpy) {
  Element& geom = add(body, "geom");
  set(geom, "type", geom_type(shape));
  set(geom, "size", std::span(size).first(static_cast<std::size_t>(size_count(shape))));
  set(geom, "pos", pos);
  if (rpy != Vec3{}) set(geom, "euler", rpy);
  return geom;
}

Element& add_bar(Element& body, Shape shape, const Vec3& from, const Vec3& to, double radius) {
  Element& geom = add(body, "geom");
  set(geom, "type", geom_type(shape));
  set(geom, "size", radius);
  set(geom, "fromto", {from[0], from[1], from[2], to[0], to[1], to[2]});
  return geom;
}

}  // namespace engram::mjcf
