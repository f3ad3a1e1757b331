#include "mjcf/table_contact.h"

#include <catch2/catch.hpp>
#include <cmath>

namespace engram::mjcf {
namespace {

TEST_CASE("The lowest point of a rotated geom is found", "[mjcf][table_contact]") {
  const double half = std::sqrt(0.5);
  Geom geom{.size = {0.01, 0.02, 0.03}, .pos = {0, 0, 0.1}};
  CHECK(lowest_point(geom) == Approx(0.07));
  geom.quat = {half, half, 0, 0};  // a quarter turn about x
  CHECK(lowest_point(geom) == Approx(0.08));
  geom.type = GeomType::kEllipsoid;
  CHECK(lowest_point(geom) == Approx(0.08));
  geom.type = GeomType::kCylinder;
  CHECK(lowest_point(geom) == Approx(0.09));
  geom.type = GeomType::kCapsule;
  CHECK(lowest_point(geom) == Approx(0.09));
  geom.type = GeomType::kSphere;
  CHECK(lowest_point(geom) == Approx(0.09));
}

TEST_CASE("A prop stands on its lowest colliding geom", "[mjcf][table_contact]") {
  Prop prop;
  prop.geoms = {{.type = GeomType::kSphere, .size = {0.02, 0, 0}},
                {.type = GeomType::kBox, .size = {0.01, 0.01, 0.03}},
                {.type = GeomType::kBox, .size = {0.01, 0.01, 0.05}, .collides = false}};
  CHECK(height_on_table(prop) == 0.03);
  CHECK(table_contact_count(prop) == 4);  // the corners of the box; the sphere hangs above
}

TEST_CASE("Contacts on the table follow from type and orientation", "[mjcf][table_contact]") {
  const double half = std::sqrt(0.5);
  const Quat lying = {half, half, 0, 0};  // a quarter turn about x
  const auto count = [](GeomType type, const Quat& quat) {
    Prop prop;
    prop.geoms = {{.type = type, .size = {0.01, 0.02, 0.03}, .quat = quat}};
    return table_contact_count(prop);
  };
  const Quat upright = {1, 0, 0, 0};
  const Quat on_an_edge = {std::cos(0.2), std::sin(0.2), 0, 0};
  CHECK(count(GeomType::kBox, upright) == 4);
  CHECK(count(GeomType::kBox, on_an_edge) == 2);
  CHECK(count(GeomType::kSphere, upright) == 1);
  CHECK(count(GeomType::kCapsule, upright) == 1);
  CHECK(count(GeomType::kCapsule, lying) == 2);
  CHECK(count(GeomType::kCylinder, upright) == 3);
  CHECK(count(GeomType::kCylinder, lying) == 2);
  CHECK(count(GeomType::kEllipsoid, upright) == 1);
}

}  // namespace
}  // namespace engram::mjcf
