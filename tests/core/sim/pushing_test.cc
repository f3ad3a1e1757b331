// Pushing, pressing and landing: no body penetrates another, none is thrown.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "core/math/random.h"
#include "mjcf/object_shapes.h"
#include "tests/core/sim/physics_fixture.h"
#include "tests/env_helpers.h"

namespace engram {
namespace {

using test::Rig;
using Vec3 = Eigen::Vector3d;

// --- landing ---

TEST_CASE("What drops does not sink into the table", "[pushing]") {
  BatchOptions options;
  options.substeps = 1;
  options.sleep = GENERATE(true, false);
  const double drop = GENERATE(0.0181, 0.02, 0.0234);  // m; the way of a substep ends elsewhere
  for (int i = 0; i < mjcf::kObjectShapeCount; ++i) {
    const auto shape = static_cast<mjcf::ObjectShape>(i);
    const mjcf::Prop prop = mjcf::shape_prop("shape", shape, {1, 0, 0, 1});
    const double rest = mjcf::resting_height(shape);
    const auto& [w, x, y, z] = prop.quat;
    Rig rig({prop},
            {{{0.05, -0.1, rest + drop}, PropStatus::kAwake, Eigen::Quaterniond(w, x, y, z)}},
            options);
    double lowest = 1;
    double highest = 0;  // after it has touched
    for (int step = 0; step < 200; ++step) {
      rig.rest(1);
      if (lowest < rest + 1e-3) highest = std::max(highest, rig.pos(0).z());
      lowest = std::min(lowest, rig.pos(0).z());
    }
    INFO("shape " << i << ", sinks " << 1000 * (rest - lowest) << " mm");
    CHECK(lowest > rest - 0.0005);
    CHECK(highest < rest + 0.001);
    CHECK(rig.pos(0).z() == Approx(rest).margin(1e-4));
  }
}

// --- pressing ---

TEST_CASE("A cube that is pressed with all force stays on the table", "[pushing]") {
  BatchOptions options;
  options.sleep = GENERATE(true, false);
  Rig rig = Rig::cubes({{{0, 0, 0.02}}}, options);
  rig.move({0, 0, 0.08}, 30, -0.6);
  double deepest = 0;
  for (int step = 0; step < 100; ++step) {
    rig.move({0, 0, -0.3}, 1, -0.6);
    deepest = std::max(deepest, 0.02 - rig.pos(0).z());
  }
  CHECK(deepest < 0.001);
  CHECK(rig.pos(0).head<2>().norm() < 0.1);  // the tips slide, and it goes along
}

// --- appearing around the fingers ---

// Motion of a shape that appears around closed fingers, which then are lifted.
struct Appearance {
  double fastest = 0;  // m/s
  double late = 0;     // m, its way in the fourth second
  Vec3 way;            // m, all in all
  double height = 0;   // m, in the end
};

Appearance appear(mjcf::ObjectShape shape, const Vec3& offset, double yaw, bool sleep) {
  const BatchOptions options{.sleep = sleep};
  const mjcf::Prop prop = mjcf::shape_prop("shape", shape, {1, 0, 0, 1});
  const double rest = mjcf::resting_height(shape);
  Rig rig({prop}, {{{0.3, 0.6, rest}, PropStatus::kHidden}}, options);
  const Vec3 slot(-0.05, 0.1, 0);
  const Vec3 parked = slot + Vec3(0, 0, 0.02);
  rig.move(parked, 60, -1);
  const Vec3 place = slot + offset + Vec3(0, 0, rest);
  const auto& [w, x, y, z] = prop.quat;
  const Eigen::Quaterniond q =
      Eigen::AngleAxisd(yaw, Vec3::UnitZ()) * Eigen::Quaterniond(w, x, y, z);
  const double quat[4] = {q.w(), q.x(), q.y(), q.z()};
  rig.state().place_prop(0, 0, place.data(), quat);
  Appearance seen;
  const auto wait = [&](int steps) {
    for (int step = 0; step < steps; ++step) {
      rig.move(parked, 1, -1);
      const Eigen::Map<const Vec3> velocity(rig.state().prop_qvel_of(0, 0));
      seen.fastest = std::max(seen.fastest, velocity.norm());
    }
    return rig.pos(0);
  };
  const Vec3 before = wait(60);
  seen.late = (wait(20) - before).norm();
  rig.move(slot + Vec3(0, 0, 0.3), 60, -1, 0.3F);
  seen.way = rig.pos(0) - place;
  seen.height = rig.pos(0).z();
  return seen;
}

// An overlap has no limit of speed, and what is pushed to both sides stays between the tips.
void check_appearances(int each) {
  constexpr double kLifted = 0.28;  // m
  const bool sleep = GENERATE(true, false);
  RandomStream random(7, 1, 0);
  int held = 0;
  int pushed = 0;
  for (int i = 0; i < each * mjcf::kObjectShapeCount; ++i) {
    const auto shape = static_cast<mjcf::ObjectShape>(i % mjcf::kObjectShapeCount);
    // One by one: the order of arguments' evaluation is the compiler's.
    const double y = random.uniform(-0.012, 0.012);
    const double x = random.uniform(-0.012, 0.012);
    const Vec3 offset(x, y, 0);
    const Appearance seen = appear(shape, offset, random.uniform(-3.1, 3.1), sleep);
    INFO(mjcf::shape_name(shape) << ", offset " << offset.transpose() << ", goes "
                                 << seen.way.transpose());
    CHECK(seen.fastest < 2);
    CHECK(seen.height > 0.5 * mjcf::resting_height(shape));
    if (seen.height > 0.05) {
      CHECK(seen.way.z() == Approx(kLifted).margin(0.03));
      ++held;
      continue;
    }
    ++pushed;
    if (shape == mjcf::ObjectShape::kSphere) continue;  // rolls on
    CHECK(seen.way.norm() < 0.5);
    CHECK(seen.late < 0.002);
  }
  CHECK(held > 0);
  CHECK(pushed > held);
}

TEST_CASE("What appears around closed fingers is pushed out or held", "[pushing]") {
  check_appearances(5);
}

TEST_CASE("What appears around closed fingers at any place is pushed out or held",
          "[pushing][long]") {
  check_appearances(12);
}

}  // namespace
}  // namespace engram
