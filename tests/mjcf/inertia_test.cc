#include "mjcf/inertia.h"

#include <catch2/catch.hpp>
#include <numbers>

namespace engram::mjcf {
namespace {

TEST_CASE("A solid of one box has the inertia of the box", "[mjcf][inertia]") {
  Prop prop;
  prop.geoms = {{.size = {0.01, 0.02, 0.03}, .pos = {0.1, 0, 0}}};
  set_solid_inertia(prop, 500);
  const double mass = 500 * 8 * 0.01 * 0.02 * 0.03;
  CHECK(prop.mass == Approx(mass));
  CHECK(prop.center_of_mass[0] == Approx(0.1));
  CHECK(prop.inertia[0] == Approx(mass / 3 * (0.02 * 0.02 + 0.03 * 0.03)));
  CHECK(prop.inertia[1] == Approx(mass / 3 * (0.01 * 0.01 + 0.03 * 0.03)));
  CHECK(prop.inertia[2] == Approx(mass / 3 * (0.01 * 0.01 + 0.02 * 0.02)));
  for (std::size_t i = 3; i < 6; ++i) CHECK(prop.inertia[i] == Approx(0).margin(1e-18));
}

TEST_CASE("Two halves of a cylinder weigh as one", "[mjcf][inertia]") {
  Prop whole;
  whole.geoms = {{.type = GeomType::kCylinder, .size = {0.02, 0.04, 0}}};
  Prop halves;
  for (const double z : {-0.02, 0.02}) {
    halves.geoms.push_back(
        {.type = GeomType::kCylinder, .size = {0.02, 0.02, 0}, .pos = {0, 0, z}});
  }
  set_solid_inertia(whole);
  set_solid_inertia(halves);
  CHECK(whole.mass == Approx(kDensity * std::numbers::pi * 0.02 * 0.02 * 0.08));
  CHECK(halves.mass == Approx(whole.mass));
  for (std::size_t i = 0; i < 6; ++i) {
    CHECK(halves.inertia[i] == Approx(whole.inertia[i]).margin(1e-18));
  }
}

}  // namespace
}  // namespace engram::mjcf
