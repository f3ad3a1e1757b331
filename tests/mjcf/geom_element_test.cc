#include "mjcf/geom_element.h"

#include <catch2/catch.hpp>
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

TEST_CASE("A geom between two points has their coordinates", "[mjcf][geom]") {
  tinyxml2::XMLDocument document;
  Element& body = *document.NewElement("body");
  document.InsertEndChild(&body);
  const Element& geom = add_fromto_geom(body, GeomType::kCapsule, {0, 0, 0}, {0, 0.5, 1}, 0.05);
  CHECK(std::string(geom.Attribute("fromto")) == "0 0 0 0 0.5 1");
  CHECK(std::string(geom.Attribute("size")) == "0.05");
}

}  // namespace
}  // namespace engram::mjcf
