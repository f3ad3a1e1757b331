#include "mjcf/geom_element.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <cstdio>
#include <string>

namespace engram::mjcf {
namespace {

TEST_CASE("A geom has as many sizes as its type", "[mjcf][geom]") {
  tinyxml2::XMLDocument document;
  Element& body = *document.NewElement("body");
  document.InsertEndChild(&body);
  const std::pair<GeomType, const char*> sizes[] = {{GeomType::kBox, "0.1 0.2 0.3"},
                                                    {GeomType::kSphere, "0.1"},
                                                    {GeomType::kCapsule, "0.1 0.2"},
                                                    {GeomType::kCylinder, "0.1 0.2"},
                                                    {GeomType::kEllipsoid, "0.1 0.2 0.3"}};
  for (const auto& [type, size] : sizes) {
    const Element& geom = add_geom(body, type, {0.1, 0.2, 0.3}, {1, 2, 3}, {});
    CHECK(std::string(geom.Attribute("type")) == geom_type(type));
    CHECK(std::string(geom.Attribute("size")) == size);
    CHECK(std::string(geom.Attribute("pos")) == "1 2 3");
    CHECK(geom.Attribute("euler") == nullptr);
  }
}

TEST_CASE("A geom between two points lies in their middle", "[mjcf][geom]") {
  tinyxml2::XMLDocument document;
  Element& body = *document.NewElement("body");
  document.InsertEndChild(&body);
  const Element& geom = add_fromto_geom(body, GeomType::kCapsule, {0, 0, 0}, {0, 0, 1}, 0.05);
  CHECK(std::string(geom.Attribute("pos")) == "0 0 0.5");
  CHECK(std::string(geom.Attribute("size")) == "0.05 0.5");
  CHECK(std::string(geom.Attribute("quat")) == "0 1 0 0");
  const Element& other = add_fromto_geom(body, GeomType::kCapsule, {0, 2, 0}, {0, 0, 0}, 0.05);
  double w = 0;
  double x = 0;
  REQUIRE(std::sscanf(other.Attribute("quat"), "%lf %lf 0 0", &w, &x) == 2);
  CHECK(w == Approx(std::sqrt(0.5)));
  CHECK(x == Approx(-std::sqrt(0.5)));
}

}  // namespace
}  // namespace engram::mjcf
