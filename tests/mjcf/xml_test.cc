#include "mjcf/xml.h"

#include <array>
#include <catch2/catch.hpp>
#include <cstdlib>
#include <string>

namespace engram::mjcf {
namespace {

TEST_CASE("Attributes read back as the same numbers", "[mjcf][xml]") {
  tinyxml2::XMLDocument document;
  Element& root = *document.NewElement("root");
  document.InsertEndChild(&root);
  for (const double number : {0.1, 1.0 / 3, -1e-300, 4.9406564584124654e-324, 12345678.9}) {
    Element& child = add(root, "child");
    set(child, "number", number);
    CHECK(std::strtod(child.Attribute("number"), nullptr) == number);
  }
}

TEST_CASE("Lists are separated by blanks", "[mjcf][xml]") {
  tinyxml2::XMLDocument document;
  Element& root = *document.NewElement("root");
  document.InsertEndChild(&root);
  set(root, "name", "table");
  set(root, "size", {1, 0.5, -2});
  set(root, "pos", std::array{0.25, 0.0});
  CHECK(std::string(root.Attribute("name")) == "table");
  CHECK(std::string(root.Attribute("size")) == "1 0.5 -2");
  CHECK(std::string(root.Attribute("pos")) == "0.25 0");
}

}  // namespace
}  // namespace engram::mjcf
