#include "mjcf/prop_limits.h"

#include <catch2/catch.hpp>
#include <string>

#include "core/base/error.h"
#include "mjcf/inertia.h"

namespace engram::mjcf {
namespace {

using Catch::Contains;

std::vector<Prop> cubes(int count, double half_size = 0.02) {
  std::vector<Prop> props;
  for (int i = 0; i < count; ++i) {
    props.push_back(cube("cube_" + std::to_string(i), half_size, {1, 0, 0, 1}));
  }
  return props;
}

TEST_CASE("A scene has at most 64 props", "[mjcf][errors]") {
  CHECK_NOTHROW(check_props(cubes(64)));
  CHECK_THROWS_WITH(check_props(cubes(65)), "65 props given, at most 64 allowed");
}

TEST_CASE("Dynamic props have the inertia that physics needs", "[mjcf][errors]") {
  CHECK_NOTHROW(check_props(cubes(1, 0.00035)));
  CHECK_THROWS_WITH(check_props(cubes(1, 0.0003)), Contains("prop 'cube_0': too small"));
  std::vector<Prop> props = cubes(1, 0.0003);
  props[0].body_type = BodyType::kKinematic;
  CHECK_NOTHROW(check_props(props));
  // Thin in two directions: one moment of three is too small.
  props[0].body_type = BodyType::kDynamic;
  props[0].geoms[0].size = {0.01, 1e-5, 1e-5};
  set_solid_inertia(props[0], 1000);
  CHECK_THROWS_WITH(check_props(props), Contains("moments of inertia of 2e-14"));
}

TEST_CASE("The contacts of a scene are bounded", "[mjcf][errors]") {
  std::vector<Prop> props = cubes(1);
  props[0].geoms.resize(300, props[0].geoms[0]);
  CHECK_NOTHROW(check_props(props));
  props[0].geoms.resize(3000, props[0].geoms[0]);
  CHECK_THROWS_WITH(check_props(props), Contains("contacts at once given, at most 5000 allowed"));
}

}  // namespace
}  // namespace engram::mjcf
