// One environment's contacts in a substep: found, solved, and remembered.
#include "core/contact/contact_step.h"

#include <catch2/catch.hpp>

#include "tests/core/collision/one_lane.h"
#include "tests/core/robot/robot_fixture.h"
#include "tests/core/scene/props.h"

namespace engram::test {
namespace {

constexpr double kTimestep = 0.01;

// The mixed scene: the first cube moves freely, the kinematic box is where it is put, and the
// others are absent.
class World {
 public:
  World()
      : bodies_(scene()),
        contacts_(scene()),
        narrow_phase_(model().full(), scene()),
        lane_(model()),
        block_(1, 1, 1, Eigen::Map<const Vec3>(model().robot_model().base_position)) {
    lane_.place_robot(kStartPose.data());
    for (int i = 0; i < kRobotJoints; ++i) {
      const double bias =
          model().robot_params().drive.stiffness * kStartPose[static_cast<std::size_t>(i)];
      lane_.robots().put(LaneVectors::kDriveBias + i, 0, &bias, 1);
    }
    const RobotPose robot = pose_at(model().robot_model(), kStartPose.data());
    for (std::size_t i = 0; i < scene().bodies().size(); ++i) {
      const CollisionBody& body = scene().bodies()[i];
      if (body.kind == BodyKind::kLink) bodies_.frames[i] = carried(robot, body.attachment);
    }
    for (const int prop : {kBall, kCube1, kBox}) {
      bodies_.presence[index(prop)] = BodyPresence::kAbsent;
    }
    memory_.pairs.reserve(static_cast<std::size_t>(max_near_pairs(scene())));
  }

  static const PhysicsModel& model() { return mixed_model(); }
  static const CollisionScene& scene() { return model().collision(); }

  FreeBodyState& cube() { return cube_; }
  void put_box(const Vec3& pos, const Vec3& velocity) {
    bodies_.presence[index(kBox)] = BodyPresence::kPresent;
    bodies_.frames[index(kBox)].pos = pos;
    bodies_.kinematic_velocities[index(kBox)] = velocity;
    bodies_.speeds[index(kBox)] = velocity.norm();
  }
  const ContactMemory& memory() const { return memory_; }
  const ContactStep& contacts() const { return contacts_; }

  void substep() {
    const FreeBody& body = model().props()[kCube0].body;
    body.accelerate(cube_, model().gravity(), kTimestep);
    block_.clear();
    block_.put_body(0, 0, body, cube_);
    bodies_.body_indices[index(kCube0)] = 0;
    bodies_.frames[index(kCube0)] = {cube_.center, cube_.quat.toRotationMatrix()};
    bodies_.speeds[index(kCube0)] = cube_.linear.norm() + 0.04 * cube_.angular.norm();
    const MujocoScope scope;
    contacts_.find(bodies_, lane_.find(bodies_), memory_, narrow_phase_, 0, block_);
    contact_kernel(1).substep(model().robot_model(), model().robot_params(), false,
                              lane_.robots().vectors(), block_.view());
    contacts_.finish(memory_, 0, block_);
    block_.get_body(0, 0, cube_);
  }

 private:
  static std::size_t index(int prop) {
    return static_cast<std::size_t>(scene().body_of_prop(prop));
  }

  BodyStates bodies_;
  ContactMemory memory_;
  ContactStep contacts_;
  NarrowPhase narrow_phase_;
  OneLane lane_;
  ContactBlock block_;
  FreeBodyState cube_;
};

TEST_CASE("A cube in the air has no contacts and falls", "[contact]") {
  World world;
  world.cube().center = {0, 0.6, 0.3};
  world.substep();
  CHECK(world.contacts().empty());
  CHECK(world.memory().pairs.empty());
  CHECK(world.cube().linear.z() == Approx(-0.0981));
}

TEST_CASE("A cube on the table rests on anchors that stay", "[contact]") {
  World world;
  world.cube().center = {0, 0.6, 0.02};
  for (int i = 0; i < 100; ++i) {
    world.substep();
    REQUIRE(world.memory().pairs.size() == 1);
    REQUIRE(world.memory().pairs[0].num_patches == 1);
    REQUIRE(world.memory().pairs[0].patches[0].num_anchors == 2);
  }
  CHECK((world.cube().center - Vec3(0, 0.6, 0.02)).norm() < 1e-5);
  CHECK(world.cube().linear.norm() < 1e-3);
}

TEST_CASE("A sliding cube drops its anchors and keeps its points, then stops", "[contact]") {
  World world;
  world.cube().center = {0, 0.6, 0.02};
  world.substep();
  world.cube().linear.x() = 0.5;
  world.substep();
  REQUIRE(world.memory().pairs.size() == 1);
  CHECK(world.memory().pairs[0].manifold.known);
  CHECK(world.memory().pairs[0].num_patches == 0);
  for (int i = 0; i < 30; ++i) world.substep();
  CHECK(world.memory().pairs[0].num_patches == 1);
  CHECK(world.cube().linear.norm() < 1e-3);
  // v^2 / (2 mu g), less half a substep
  CHECK(world.cube().center.x() == Approx(0.5 * 0.5 / (2 * 0.3 * 9.81)).margin(0.003));
}

TEST_CASE("A kinematic box carries a cube that lies on it", "[contact]") {
  World world;
  world.cube().center = {0, 0.6, 0.06};
  Vec3 box(0, 0.6, 0.02);
  const Vec3 velocity(0.05, 0, 0);
  for (int i = 0; i < 50; ++i) {
    world.put_box(box, velocity);
    world.substep();
    box += kTimestep * velocity;
  }
  CHECK(world.cube().linear.x() == Approx(0.05).margin(1e-3));
  CHECK(world.cube().center.x() == Approx(box.x()).margin(1e-3));
  CHECK(world.cube().center.z() == Approx(0.06).margin(1e-4));
}

}  // namespace
}  // namespace engram::test
