#include "core/sim/state_transfer.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <limits>
#include <vector>

#include "tests/core/collision/one_lane.h"
#include "tests/core/sim/columns_fixture.h"

namespace engram {
namespace {

const PhysicsModel& model() { return test::mixed_model(); }

// One environment's columns, and the working memory of its steps.
class Fixture {
 public:
  const State& state() const { return columns_.state; }
  StepWorkspace& workspace() { return workspace_; }
  const test::MixedColumns& columns() const { return columns_; }
  EnvStep step() { return {model(), columns_.state, 0, workspace_, clearance_, nullptr}; }

  void pose_bodies(StateTransfer& transfer, const double* qpos, const JointArray& qvel) {
    lane_.place_robot(qpos, qvel);
    transfer.pose_links(pose_at(model().robot_model(), qpos), lane_.broad_phase(), 0);
    transfer.pose_props(lane_.broad_phase(), 0);
  }

  // What the contact law remembers, as the next step reads it.
  std::vector<ContactPair> remembered() {
    EnvStep next = step();
    StateTransfer transfer(next);
    transfer.begin(true);
    transfer.load_contacts();
    return workspace_.memory.pairs;
  }
  // Stores these pairs at the end of a step.
  void remember(const std::vector<ContactPair>& pairs) {
    EnvStep last = step();
    StateTransfer transfer(last);
    transfer.begin(true);
    transfer.load_contacts();
    workspace_.memory.pairs.assign(pairs.begin(), pairs.end());
    transfer.store({}, {});
  }

 private:
  test::MixedColumns columns_;
  StepWorkspace workspace_{model()};
  test::OneLane lane_{model()};
  RobotBounds::Clearance clearance_;
};

// The first pair of shapes of two props of the task, or of a prop and the table (-1).
int pair_of(int first, int second) {
  const CollisionScene& scene = model().collision();
  const auto prop_of = [&](int shape) {
    const int body = scene.shapes()[static_cast<std::size_t>(shape)].body;
    return scene.bodies()[static_cast<std::size_t>(body)].prop;
  };
  for (std::size_t i = 0; i < scene.shape_pairs().size(); ++i) {
    const ShapePair& pair = scene.shape_pairs()[i];
    if (prop_of(pair.a) == first && prop_of(pair.b) == second) return static_cast<int>(i);
  }
  FAIL("no such pair");
  return -1;
}

ContactPair touching(int shape_pair) {
  ContactPair pair;
  pair.shape_pair = shape_pair;
  pair.manifold.known = true;
  pair.manifold.num_points = 2;
  pair.manifold.points[1].a = {0.125, 0.25, 0.5 + shape_pair};
  pair.num_patches = 1;
  pair.patches[0].num_anchors = 2;
  pair.patches[0].anchors[1].b = {0.375, 0.5, 0.75 + shape_pair};
  return pair;
}

TEST_CASE("Contacts are remembered from step to step, in the order of solving",
          "[state_transfer]") {
  Fixture fixture;
  CHECK(fixture.remembered().empty());
  const std::vector<ContactPair> pairs = {touching(pair_of(test::kBall, -1)),
                                          touching(pair_of(test::kCube0, test::kBall)),
                                          touching(pair_of(test::kCube0, -1))};
  fixture.remember(pairs);
  const std::vector<ContactPair> loaded = fixture.remembered();
  REQUIRE(loaded.size() == 3);
  for (std::size_t i = 0; i < 3; ++i) {
    CHECK(loaded[i].shape_pair == pairs[i].shape_pair);
    CHECK(loaded[i].manifold.known);
    CHECK(loaded[i].manifold.points[1].a == pairs[i].manifold.points[1].a);
    CHECK(loaded[i].num_patches == 1);
    CHECK(loaded[i].patches[0].anchors[1].b == pairs[i].patches[0].anchors[1].b);
  }
  fixture.remember({pairs[2]});
  REQUIRE(fixture.remembered().size() == 1);
  CHECK(fixture.remembered()[0].shape_pair == pairs[2].shape_pair);
}

TEST_CASE("A placed prop's contacts are forgotten, and no other's", "[state_transfer]") {
  Fixture fixture;
  fixture.remember({touching(pair_of(test::kCube0, test::kBall)),
                    touching(pair_of(test::kBall, -1)), touching(pair_of(test::kCube0, -1))});
  fixture.columns().place(0, test::kCube0, {0, 0.3, 0.02}, PropStatus::kAwake);
  const std::vector<ContactPair> loaded = fixture.remembered();
  REQUIRE(loaded.size() == 3);
  for (const std::size_t i : {0, 2}) {
    CHECK_FALSE(loaded[i].manifold.known);
    CHECK(loaded[i].num_patches == 0);
  }
  CHECK(loaded[1].manifold.known);
  CHECK(loaded[1].num_patches == 1);
}

TEST_CASE("Numbers that no pair has are left out", "[state_transfer]") {
  Fixture fixture;
  fixture.remember({touching(pair_of(test::kBall, -1)), touching(pair_of(test::kCube0, -1))});
  fixture.state().contact_ids.row(0)[StoredPair::kPatches] = 1000;
  REQUIRE(fixture.remembered().size() == 1);
  CHECK(fixture.remembered()[0].shape_pair == pair_of(test::kCube0, -1));
}

TEST_CASE("A step in which nothing may touch leaves the memory as it is", "[state_transfer]") {
  Fixture fixture;
  fixture.remember({touching(pair_of(test::kBall, -1))});
  EnvStep step = fixture.step();
  StateTransfer transfer(step);
  transfer.begin(true);
  fixture.workspace().memory.pairs.clear();
  transfer.store({}, {});
  CHECK(fixture.remembered().size() == 1);
}

TEST_CASE("Columns without room for contacts remember none", "[state_transfer]") {
  ColumnStore store(1);
  const State state(store, 4);
  StepWorkspace workspace(model());
  RobotBounds::Clearance clearance;
  EnvStep step(model(), state, 0, workspace, clearance, nullptr);
  StateTransfer transfer(step);
  transfer.begin(true);
  transfer.load_contacts();
  workspace.memory.pairs.push_back(touching(pair_of(test::kBall, -1)));
  transfer.store({}, {});
  CHECK(state.contact_ids.row(0)[StoredPair::kShapePair] == 0);
}

TEST_CASE("A kinematic prop is where it has come to in this substep", "[state_transfer]") {
  Fixture fixture;
  const double to[3] = {-0.1, 0.5, 0.02};  // 0.1 m in x
  fixture.state().move_kinematic(0, test::kBox, to);
  EnvStep step = fixture.step();
  StateTransfer transfer(step);
  transfer.begin(true);
  CHECK(step.is_moving(test::kBox));
  transfer.move_kinematic_props(2, 5);
  fixture.pose_bodies(transfer, test::kStartPose.data(), {});
  const auto body = static_cast<std::size_t>(model().collision().body_of_prop(test::kBox));
  const BodyStates& bodies = fixture.workspace().bodies;
  CHECK(bodies.frames[body].pos.isApprox(Vec3(-0.16, 0.5, 0.02)));
  CHECK(bodies.kinematic_velocities[body].isApprox(Vec3(2, 0, 0)));
  CHECK(bodies.speeds[body] == Approx(2));
  transfer.move_kinematic_props(5, 5);
  transfer.store({}, {});
  CHECK(fixture.state().prop_pos_of(0, test::kBox)[0] == Approx(-0.1));
  CHECK(fixture.state().prop_qvel_of(0, test::kBox)[0] == 0);
  CHECK(fixture.state().status_of(0, test::kBox) == PropStatus::kAsleep);
}

TEST_CASE("Bodies are present, resting or absent as their props are", "[state_transfer]") {
  Fixture fixture;
  const auto presence = [&](int prop) {
    const int body = model().collision().body_of_prop(prop);
    return fixture.workspace().bodies.presence[static_cast<std::size_t>(body)];
  };
  for (const bool sleep : {true, false}) {
    EnvStep step = fixture.step();
    StateTransfer transfer(step);
    transfer.begin(sleep);
    fixture.pose_bodies(transfer, test::kStartPose.data(), {});
    CHECK(presence(test::kCube0) == BodyPresence::kPresent);
    CHECK(presence(test::kBall) == (sleep ? BodyPresence::kResting : BodyPresence::kPresent));
    CHECK(presence(test::kCube1) == BodyPresence::kAbsent);
    CHECK(presence(test::kBox) == BodyPresence::kPresent);
  }
}

TEST_CASE("No point of a link is faster than its bound", "[state_transfer]") {
  constexpr double kStep = 1e-6;  // s
  Fixture fixture;
  JointArray qpos;
  std::copy(test::kStartPose.begin(), test::kStartPose.end(), qpos.begin());
  const JointArray qvel = {0.5, -1, 0.8, 2, -0.3, 1, 2, -0.1, 0.1};
  JointArray later = qpos;
  for (std::size_t i = 0; i < kRobotJoints; ++i) later[i] += kStep * qvel[i];
  EnvStep step = fixture.step();
  StateTransfer transfer(step);
  transfer.begin(true);
  const auto frames_at = [&](const JointArray& q) {
    fixture.pose_bodies(transfer, q.data(), qvel);
    return fixture.workspace().bodies.frames;
  };
  const std::vector<Frame> after = frames_at(later);
  const std::vector<Frame> before = frames_at(qpos);
  const CollisionScene& scene = model().collision();
  double fastest = 0;
  for (const CollisionShape& shape : scene.shapes()) {
    const auto body = static_cast<std::size_t>(shape.body);
    if (scene.bodies()[body].kind != BodyKind::kLink) continue;
    const Vec3& point = shape.frame.pos;
    const Vec3 moved = (after[body].pos + after[body].axes * point) -
                       (before[body].pos + before[body].axes * point);
    const double speed = moved.norm() / kStep;
    CHECK(speed <= fixture.workspace().bodies.speeds[body] + 1e-6);
    fastest = std::max(fastest, speed);
  }
  CHECK(fastest > 0.5);
}

TEST_CASE("A state with a number that is not finite or huge is not plausible", "[state_transfer]") {
  for (const double bad :
       {std::numeric_limits<double>::quiet_NaN(), -std::numeric_limits<double>::infinity(), 1e11}) {
    Fixture fixture;
    EnvStep step = fixture.step();
    StateTransfer transfer(step);
    CHECK(transfer.state_is_plausible());
    transfer.begin(true);
    CHECK(transfer.is_plausible({}, {}));
    JointArray qvel{};
    qvel[8] = bad;
    CHECK_FALSE(transfer.is_plausible({}, qvel));
    fixture.workspace().motion[test::kCube0].angular.y() = bad;
    CHECK_FALSE(transfer.is_plausible({}, {}));
    fixture.state().prop_qvel_of(0, test::kBall)[5] = bad;
    CHECK_FALSE(transfer.state_is_plausible());
  }
}

}  // namespace
}  // namespace engram
