#include "mjcf/object_descriptor.h"

#include <catch2/catch.hpp>

#include "mjcf/button.h"
#include "mjcf/peg.h"
#include "mjcf/target_disc.h"

namespace engram::mjcf {
namespace {

TEST_CASE("A cube is described by kind, shape, size and colour", "[mjcf][object_descriptor]") {
  const ObjectDescriptor cube_descriptor = describe_object(cube("cube", 0.02, {1, 0, 0, 1}));
  CHECK(cube_descriptor.kind == ObjectKind::kObject);
  CHECK(cube_descriptor.shape == static_cast<int>(ObjectShape::kCube));
  CHECK(cube_descriptor.color == nearest_object_color(1, 0, 0));
  CHECK(cube_descriptor.half_size == std::array{0.02, 0.02, 0.02});
  CHECK(cube_descriptor.rest_height == 0.02);
}

TEST_CASE("A peg has the box around both halves and no listed shape", "[mjcf][object_descriptor]") {
  const ObjectDescriptor peg_descriptor =
      describe_object(peg("peg", 0.1, 0.02, {1, 0, 0, 1}, {0, 0, 1, 1}));
  CHECK(peg_descriptor.kind == ObjectKind::kPeg);
  CHECK(peg_descriptor.shape == -1);
  CHECK(peg_descriptor.half_size[0] == Approx(0.1));
  CHECK(peg_descriptor.half_size[1] == Approx(0.02));
}

TEST_CASE("A button's cap reports its travel", "[mjcf][object_descriptor]") {
  const ButtonShape shape;
  const ObjectDescriptor cap = describe_object(button_cap("cap", shape, 0.01));
  CHECK(cap.kind == ObjectKind::kButton);
  CHECK(cap.travel == 0.01);
  CHECK(cap.rest_height == shape.cap_height());
}

TEST_CASE("A prop hidden from sensors is no object", "[mjcf][object_descriptor]") {
  const Rgba red = {1, 0, 0, 1};
  CHECK(describe_object(target_disc("target", 0.1, red)).kind == ObjectKind::kPlace);
  CHECK(describe_object(target_disc("target", 0.1, red, true)).kind == ObjectKind::kPart);
}

}  // namespace
}  // namespace engram::mjcf
