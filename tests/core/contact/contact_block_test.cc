#include "core/contact/contact_block.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "core/contact/contact_kernel.h"
#include "core/robot/lane_block.h"
#include "tests/core/robot/robot_fixture.h"
#include "tests/core/scene/props.h"

namespace engram::test {
namespace {

constexpr double kTimestep = 0.01;
constexpr double kMass = 0.064;  // kg, of a cube

const PhysicsModel& model() { return mixed_model(); }
const FreeBody& cube() { return model().props()[kCube0].body; }

// A block of four lanes, with a robot at rest in each.
class Block {
 public:
  Block()
      : robots_(*lane_kernel(kLanes)),
        block_(kLanes, 2, 2, Eigen::Map<const Vec3>(model().robot_model().base_position)) {
    const double stiffness = model().robot_params().drive.stiffness;
    for (int lane = 0; lane < kLanes; ++lane) {
      robots_.put(LaneVectors::kQ, lane, kStartPose.data(), kRobotJoints);
      for (int i = 0; i < kRobotJoints; ++i) {
        const double bias = stiffness * kStartPose[static_cast<std::size_t>(i)];
        robots_.put(LaneVectors::kDriveBias + i, lane, &bias, 1);
      }
    }
    block_.clear();
  }
  ContactBlock& operator*() { return block_; }
  ContactBlock* operator->() { return &block_; }
  void step() {
    contact_kernel(kLanes).substep(model().robot_model(), model().robot_params(), false,
                                   robots_.vectors(), block_.view());
  }

 private:
  static constexpr int kLanes = 4;

  LaneBlock robots_;
  ContactBlock block_;
};

FreeBodyState cube_at(const Vec3& center, const Vec3& velocity) {
  FreeBodyState state;
  state.center = center;
  state.linear = velocity;
  return state;
}

// Four points under a cube.
PatchSpec under(const Vec3& center, double gap = 0) {
  PatchSpec spec;
  spec.list = PatchLists::kFixed;
  spec.body_a = 0;
  spec.friction = 0.3;
  spec.normal = Vec3::UnitZ();
  for (const Vec3& corner :
       {Vec3(0.02, 0.02, 0), Vec3(0.02, -0.02, 0), Vec3(-0.02, -0.02, 0), Vec3(-0.02, 0.02, 0)}) {
    spec.points[static_cast<std::size_t>(spec.num_points)] = center + corner - Vec3(0, 0, 0.02);
    spec.gaps[static_cast<std::size_t>(spec.num_points++)] = gap;
  }
  return spec;
}
PatchSpec with_anchors(PatchSpec spec) {
  spec.num_anchors = 2;
  spec.anchors_a = spec.anchors_b = {spec.points[0], spec.points[2]};
  return spec;
}

TEST_CASE("A body without contacts moves by its velocities", "[contact]") {
  Block block;
  FreeBodyState state = cube_at({0.1, 0.2, 0.3}, {0.5, 0, -1});
  state.angular = {0, 0, 2};
  block->put_body(1, 0, cube(), state);
  block.step();
  block->get_body(1, 0, state);
  // Displacements are floats.
  CHECK(state.center.isApprox(Vec3(0.105, 0.2, 0.29), 1e-8));
  CHECK(state.linear.isApprox(Vec3(0.5, 0, -1), 1e-15));
  CHECK(state.quat.angularDistance(Quat(Eigen::AngleAxisd(2 * kTimestep, Vec3::UnitZ()))) < 1e-8);
}

TEST_CASE("A cube that falls on the table stops there, by the impulse of its patch", "[contact]") {
  Block block;
  const Vec3 center(0.1, 0.2, 0.02);
  FreeBodyState state = cube_at(center, {0, 0, -1});
  block->put_body(0, 0, cube(), state);
  const int patch = block->add_patch(0, under(center));
  block.step();
  block->get_body(0, 0, state);
  CHECK(state.linear.norm() < 1e-5);
  CHECK((state.center - center).norm() < 1e-6);
  CHECK(block->impulse(0, patch).isApprox(Vec3(0, 0, kMass), 1e-5));
}

TEST_CASE("Friction holds a slow cube, and slips under a fast one", "[contact]") {
  Block block;
  const Vec3 center(0.1, 0.2, 0.02);
  const double down = 0.0981;  // m/s, of a substep's weight
  for (const double along : {0.02, 0.5}) {
    CAPTURE(along);
    block->clear();
    FreeBodyState state = cube_at(center, {along, 0, -down});
    block->put_body(0, 0, cube(), state);
    const int patch = block->add_patch(0, with_anchors(under(center)));
    block.step();
    block->get_body(0, 0, state);
    const bool slips = along > 0.3 * down;
    CHECK(block->is_slipping(0, patch) == slips);
    // It tilts a little while it is held.
    CHECK(state.linear.x() == Approx(slips ? along - 0.3 * down : 0).margin(slips ? 1e-3 : 2e-3));
    // The impulse is the change of momentum.
    const Vec3 change = kMass * (state.linear - Vec3(along, 0, -down));
    CHECK((block->impulse(0, patch) - change).norm() < 1e-8);
  }
}

TEST_CASE("Two bodies that collide keep their momentum", "[contact]") {
  Block block;
  FreeBodyState a = cube_at({0, 0, 0.5}, {-0.4, 0.1, 0});
  FreeBodyState b = cube_at({-0.04, 0, 0.5}, {0.2, 0, 0});
  const Vec3 before = a.linear + b.linear;
  block->put_body(1, 0, cube(), a);
  block->put_body(1, 1, cube(), b);
  PatchSpec spec;
  spec.list = PatchLists::kMoving;
  spec.body_a = 0;
  spec.body_b = 1;
  spec.normal = Vec3::UnitX();
  spec.num_points = 1;
  spec.points[0] = {-0.02, 0, 0.5};
  const int patch = block->add_patch(1, spec);
  block.step();
  block->get_body(1, 0, a);
  block->get_body(1, 1, b);
  CHECK((a.linear + b.linear - before).norm() < 1e-7);
  CHECK(a.linear.x() == Approx(b.linear.x()).margin(1e-6));
  CHECK(block->impulse(1, patch).isApprox(Vec3(0.3 * kMass, 0, 0), 1e-6));
}

TEST_CASE("A kinematic body carries along what lies on it", "[contact]") {
  Block block;
  const Vec3 center(0.1, 0.2, 0.02);
  FreeBodyState state = cube_at(center, {0, 0, -0.0981});
  block->put_body(0, 0, cube(), state);
  PatchSpec spec = with_anchors(under(center));
  spec.kinematic_velocity = {0.02, 0, 0};
  block->add_patch(0, spec);
  block.step();
  block->get_body(0, 0, state);
  CHECK(state.linear.x() == Approx(0.02).margin(2e-3));
}

TEST_CASE("A lane's list of patches has its limit, which other lanes do not share", "[contact]") {
  Block block;
  const Vec3 center(0.1, 0.2, 0.02);
  block->put_body(0, 0, cube(), cube_at(center, Vec3::Zero()));
  block->put_body(1, 0, cube(), cube_at(center, Vec3::Zero()));
  int added = 0;
  while (added < 1000 && block->add_patch(0, under(center)) >= 0) ++added;
  CHECK(added >= 8 + 3);
  CHECK(added < 1000);
  CHECK(block->add_patch(1, under(center)) >= 0);
  PatchSpec moving = under(center);
  moving.list = PatchLists::kMoving;
  CHECK(block->add_patch(0, moving) >= 0);
  block->clear();
  CHECK(block->add_patch(0, under(center)) >= 0);
}

TEST_CASE("Nothing of the last substep is left after a new one begins", "[contact]") {
  Block block;
  const Vec3 center(0.1, 0.2, 0.02);
  block->put_body(0, 0, cube(), cube_at(center, {0, 0, -1}));
  block->put_body(0, 1, cube(), cube_at(center, {0, 0, -1}));
  block->add_patch(0, with_anchors(under(center)));
  block.step();
  block->clear();
  FreeBodyState state = cube_at(center, {0, 0, -1});
  block->put_body(0, 0, cube(), state);
  const ContactLanes& lanes = block->view();
  CHECK(lanes.num_bodies == 1);
  for (const int size : lanes.lists.size) CHECK(size == 0);
  block.step();
  block->get_body(0, 0, state);
  CHECK(state.center.z() == Approx(0.01));
}

}  // namespace
}  // namespace engram::test
