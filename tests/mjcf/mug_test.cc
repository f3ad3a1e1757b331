// The mug: sizes, weight, a closed wall around an empty inside, and rest on its rim.
#include "mjcf/mug.h"

#include <Eigen/Dense>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "tests/core/sim/physics_fixture.h"

namespace engram {
namespace {

using mjcf::Geom, mjcf::GeomType, mjcf::Prop;

Eigen::Vector3d vec(const mjcf::Vec3& v) { return {v[0], v[1], v[2]}; }

bool contains(const Geom& geom, const Eigen::Vector3d& point) {
  const mjcf::Quat& q = geom.quat;
  const Eigen::Vector3d local =
      Eigen::Quaterniond(q[0], q[1], q[2], q[3]).conjugate() * (point - vec(geom.pos));
  if (geom.type == GeomType::kBox) {
    return (local.cwiseAbs() - vec(geom.size)).maxCoeff() <= 0;
  }
  REQUIRE(geom.type == GeomType::kCylinder);
  return local.head<2>().norm() <= geom.size[0] && std::abs(local.z()) <= geom.size[1];
}

bool seen_at(const Prop& prop, const Eigen::Vector3d& point) {
  return std::any_of(prop.geoms.begin(), prop.geoms.end(),
                     [&](const Geom& p) { return p.visible && contains(p, point); });
}

// The parts that collide, in the frame of the mug.
TEST_CASE("The mug collides as the table of parts says", "[mjcf][mug]") {
  struct Part {
    GeomType type;
    Eigen::Vector3d pos;
    Eigen::Vector3d size;
  };
  const Part parts[] = {
      {GeomType::kCylinder, {-0.0081, -0.0002, 0}, {0.0533, 0.0528, 0}},
      {GeomType::kCylinder, {-0.0081, -0.0002, 0.0496}, {0.0607, 0.0033, 0}},
      {GeomType::kBox, {0.0605, -0.0519, 0}, {0.0058, 0.0087, 0.0280}},
      {GeomType::kBox, {0.0446, -0.0410, -0.031}, {0.0145, 0.0087, 0.0050}},
      {GeomType::kBox, {0.0446, -0.0410, 0.031}, {0.0145, 0.0087, 0.0050}},
  };
  const Prop prop = mjcf::mug("mug");
  std::vector<Geom> touchable;
  for (const Geom& p : prop.geoms) {
    CHECK(p.collides != p.visible);
    if (p.collides) touchable.push_back(p);
  }
  REQUIRE(touchable.size() == std::size(parts));
  for (std::size_t i = 0; i < std::size(parts); ++i) {
    INFO("part " << i);
    CHECK(touchable[i].type == parts[i].type);
    CHECK((vec(touchable[i].pos) - parts[i].pos).norm() < 3e-4);
    CHECK((vec(touchable[i].size) - parts[i].size).norm() < 2e-4);
  }
  const double yaw = 2 * std::atan2(touchable[2].quat[3], touchable[2].quat[0]);
  CHECK(yaw * 180 / std::numbers::pi == Approx(-34.1));
}

TEST_CASE("The mug weighs as published", "[mjcf][mug]") {
  const Prop prop = mjcf::mug("mug");
  CHECK(prop.mass == 0.30);
  CHECK((vec(prop.center_of_mass) - Eigen::Vector3d(-0.0066, -0.0024, -0.0172)).norm() < 2e-4);
  const double moments[] = {4.64e-4, 4.81e-4, 6.40e-4};
  for (std::size_t i = 0; i < 3; ++i) CHECK(prop.inertia[i] == Approx(moments[i]).epsilon(0.01));
  for (std::size_t i = 3; i < 6; ++i) CHECK(std::abs(prop.inertia[i]) < 3e-5);
}

TEST_CASE("Another handle angle rotates the whole mug", "[mjcf][mug]") {
  const Prop one = mjcf::mug("mug");
  const Prop other = mjcf::mug("mug", 0);
  const Eigen::AngleAxisd turn(-mjcf::kMugHandleYaw, Eigen::Vector3d::UnitZ());
  REQUIRE(one.geoms.size() == other.geoms.size());
  for (std::size_t i = 0; i < one.geoms.size(); ++i) {
    CHECK((turn * vec(one.geoms[i].pos) - vec(other.geoms[i].pos)).norm() < 1e-12);
  }
  CHECK((turn * vec(one.center_of_mass) - vec(other.center_of_mass)).norm() < 1e-12);
  CHECK(one.inertia[0] + one.inertia[1] == Approx(other.inertia[0] + other.inertia[1]));
}

TEST_CASE("The mug's wall is closed and its inside is empty", "[mjcf][mug]") {
  const Prop prop = mjcf::mug("mug");
  const Eigen::Vector3d axis(-0.0081, -0.0002, 0);
  const double rim = mjcf::kMugRestingHeight;
  for (int i = 0; i < 720; ++i) {
    const double angle = i * std::numbers::pi / 360;
    const Eigen::Vector3d outwards(std::cos(angle), std::sin(angle), 0);
    for (double z = -rim + 0.0005; z < rim; z += 0.002) {
      const Eigen::Vector3d height(0, 0, z);
      CHECK(seen_at(prop, axis + 0.0524 * outwards + height));
      for (const double radius : {0.0, 0.02, 0.04, 0.0505}) {
        CHECK(seen_at(prop, axis + radius * outwards + height) == (z < -rim + 0.002));
      }
    }
  }
}

TEST_CASE("A mug rests on its rim without creeping or sinking", "[mjcf][mug]") {
  const double quat[2][4] = {{0, 0.894427191, 0.447213595, 0}, {0, 0.371390676, 0.928476691, 0}};
  for (const auto& q : quat) {
    const test::Placement place{{0.1, -0.15, mjcf::kMugRestingHeight},
                                PropStatus::kAwake,
                                Eigen::Quaterniond(q[0], q[1], q[2], q[3])};
    const BatchOptions options{.sleep = false};
    test::Rig rig({mjcf::mug("mug")}, {place}, options);
    double highest_speed = 0;
    for (int i = 0; i < 100; ++i) {
      rig.rest(1);
      const Eigen::Map<Eigen::Vector3d> velocity(rig.state().prop_qvel_of(0, 0));
      highest_speed = std::max(highest_speed, velocity.norm());
    }
    CHECK((rig.pos(0) - place.pos).norm() < 2e-4);
    CHECK(highest_speed < 0.005);
  }
}

}  // namespace
}  // namespace engram
