#include "mjcf/xml.h"

#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "core/math/random.h"

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

TEST_CASE("Quaternions are such that to normalize them changes no bit", "[mjcf][xml]") {
  tinyxml2::XMLDocument document;
  Element& root = *document.NewElement("root");
  document.InsertEndChild(&root);
  set_rotation(root, {1, 0, 0, 0});
  CHECK(root.Attribute("quat") == nullptr);
  RandomStream random(3, 0, 0);
  for (int i = 0; i < 1000; ++i) {
    set_rotation(root, {random.normal(), random.normal(), random.normal(), random.normal()});
    double q[4] = {};
    REQUIRE(std::sscanf(root.Attribute("quat"), "%lf %lf %lf %lf", q, q + 1, q + 2, q + 3) == 4);
    REQUIRE(std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]) == 1);
  }
}

TEST_CASE("Inertia is written in its principal axes", "[mjcf][xml]") {
  tinyxml2::XMLDocument document;
  Element& body = *document.NewElement("body");
  document.InsertEndChild(&body);
  add_inertial(body, 2, {0, 0, 1}, {3, 4, 2, 0.5, -0.25, 0.125});
  const Element& element = *body.FirstChildElement("inertial");
  double q[4] = {};
  double m[3] = {};
  REQUIRE(std::sscanf(element.Attribute("quat"), "%lf %lf %lf %lf", q, q + 1, q + 2, q + 3) == 4);
  REQUIRE(std::sscanf(element.Attribute("diaginertia"), "%lf %lf %lf", m, m + 1, m + 2) == 3);
  const Mat3 axes = Eigen::Quaterniond(q[0], q[1], q[2], q[3]).toRotationMatrix();
  const Mat3 expected{{3, 0.5, -0.25}, {0.5, 4, 0.125}, {-0.25, 0.125, 2}};
  CHECK((axes * Eigen::Vector3d(m[0], m[1], m[2]).asDiagonal() * axes.transpose())
            .isApprox(expected));
  add_inertial(*body.InsertNewChildElement("body"), 1, {0, 0, 0}, {3, 4, 2, 0, 0, 0});
  const Element& aligned = *body.LastChildElement()->FirstChildElement("inertial");
  CHECK(aligned.Attribute("quat") == nullptr);
  CHECK(std::string(aligned.Attribute("diaginertia")) == "3 4 2");
}

}  // namespace
}  // namespace engram::mjcf
