#include "core/collision/broad_phase.h"

#include <catch2/catch.hpp>
#include <vector>

#include "core/math/random.h"
#include "tests/core/collision/one_lane.h"
#include "tests/core/robot/robot_fixture.h"
#include "tests/core/scene/props.h"

namespace engram::test {
namespace {

const CollisionScene& scene() { return mixed_model().collision(); }

// One environment: the robot anywhere, props near one another on the table, some absent.
struct World {
  explicit World(RandomStream& random) : robot(random_robot(random)), bodies(scene()) {
    for (int prop = 0; prop < 4; ++prop) {
      const auto body = static_cast<std::size_t>(scene().body_of_prop(prop));
      const double x = random.uniform(-0.1, 0.1);
      const double y = random.uniform(0.5, 0.7);
      const Quat quat(random.normal(), random.normal(), random.normal(), random.normal());
      bodies.frames[body] = {Vec3(x, y, random.uniform(0.02, 0.1)),
                             quat.normalized().toRotationMatrix()};
      bodies.speeds[body] = random.uniform(0, 2);
      if (random.uniform(0, 1) < 0.2) bodies.presence[body] = BodyPresence::kAbsent;
    }
  }

  Robot robot;
  BodyStates bodies;
};

std::vector<int> pairs_of(const BroadPhase& broad_phase, int lane) {
  std::vector<int> pairs;
  for (const NearShapes& near : broad_phase.near()) {
    if ((near.lanes >> lane & 1U) != 0) pairs.push_back(near.shape_pair);
  }
  return pairs;
}

TEST_CASE("Lanes of all widths find what one finds", "[broad_phase]") {
  RandomStream random(3, 0, 0);
  OneLane single(mixed_model());
  int found = 0;
  for (int lanes = 4; lanes <= kMaxLanes; lanes *= 2) {
    const LaneKernel* const kernel = lane_kernel(lanes);
    if (kernel == nullptr) continue;
    LaneBlock robots(*kernel);
    BroadPhase broad_phase(scene(), mixed_model().robot_params().timestep, lanes);
    for (int round = 0; round < 50; ++round) {
      std::vector<World> worlds;
      for (int lane = 0; lane < lanes; ++lane) {
        const World& world = worlds.emplace_back(random);
        robots.put(LaneVectors::kQ, lane, world.robot.q.data(), kRobotJoints);
        robots.put(LaneVectors::kV, lane, world.robot.v.data(), kRobotJoints);
      }
      kernel->pose_links(mixed_model().robot_model(), robots.vectors());
      contact_kernel(lanes).pose_robot(mixed_model().robot_model(), robots.vectors(),
                                       broad_phase.view());
      broad_phase.clear();
      // The first lane takes no part.
      for (int lane = 1; lane < lanes; ++lane) {
        const BodyStates& bodies = worlds[static_cast<std::size_t>(lane)].bodies;
        for (int prop = 0; prop < 4; ++prop) {
          const int body = scene().body_of_prop(prop);
          const auto i = static_cast<std::size_t>(body);
          broad_phase.put(lane, body, bodies.frames[i], bodies.speeds[i]);
        }
        broad_phase.enter(lane, bodies.presence);
      }
      contact_kernel(lanes).find_near(broad_phase.view());
      CHECK(pairs_of(broad_phase, 0).empty());
      for (int lane = 1; lane < lanes; ++lane) {
        const World& world = worlds[static_cast<std::size_t>(lane)];
        single.place_robot(world.robot.q.data(), world.robot.v);
        const std::vector<int> expected = pairs_of(single.find(world.bodies), 0);
        CHECK(pairs_of(broad_phase, lane) == expected);
        CHECK(broad_phase.fastest_link(lane) == single.broad_phase().fastest_link(0));
        found += static_cast<int>(expected.size());
      }
    }
  }
  CHECK(found > 1000);
}

}  // namespace
}  // namespace engram::test
