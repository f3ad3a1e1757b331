#include "core/collision/pair_search.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <vector>

#include "core/math/random.h"
#include "tests/core/collision/one_lane.h"
#include "tests/core/scene/props.h"

namespace engram {
namespace {

constexpr double kTimestep = 0.01;
constexpr int kSubsteps = 5;

// The mixed scene with the robot out of the way; props move at constant velocity.
class World {
 public:
  World()
      : bodies_(scene()), lane_(model()), search_(scene()), narrow_phase_(model().full(), scene()) {
    place_robot(test::kStartPose.data(), {});
    memory_.pairs.reserve(static_cast<std::size_t>(max_near_pairs(scene())));
    for (int prop = 0; prop < 4; ++prop) place(prop, {0.1 * prop, 0.6, 1}, Vec3::Zero());
  }

  static const PhysicsModel& model() { return test::mixed_model(); }
  static const CollisionScene& scene() { return model().collision(); }

  void place_robot(const double* qpos, const JointArray& qvel) {
    lane_.place_robot(qpos, qvel);
    const RobotPose robot = pose_at(model().robot_model(), qpos);
    for (std::size_t i = 0; i < scene().bodies().size(); ++i) {
      const CollisionBody& body = scene().bodies()[i];
      if (body.kind == BodyKind::kLink) bodies_.frames[i] = carried(robot, body.attachment);
    }
  }
  void place(int prop, const Vec3& pos, const Vec3& velocity, const Quat& quat = Quat::Identity()) {
    const std::size_t body = index(prop);
    bodies_.frames[body] = {pos, quat.toRotationMatrix()};
    bodies_.speeds[body] = velocity.norm();
    velocities_[static_cast<std::size_t>(prop)] = velocity;
  }
  void set_presence(int prop, BodyPresence presence) { bodies_.presence[index(prop)] = presence; }
  const Frame& frame(int prop) const { return bodies_.frames[index(prop)]; }

  void find() {
    const MujocoScope scope;
    search_.find(bodies_, lane_.find(bodies_), 0, memory_, narrow_phase_);
  }
  void move() {
    for (int prop = 0; prop < 4; ++prop) {
      bodies_.frames[index(prop)].pos += kTimestep * velocities_[static_cast<std::size_t>(prop)];
    }
  }

  // Pairs of shapes found, in the order of solving.
  std::vector<int> found() const {
    std::vector<int> pairs;
    search_.for_each([&](const NearPair& near) { pairs.push_back(near.shape_pair); });
    return pairs;
  }
  const ContactMemory& memory() const { return memory_; }
  std::vector<int> remembered() const {
    std::vector<int> pairs;
    for (const ContactPair& pair : memory_.pairs) pairs.push_back(pair.shape_pair);
    return pairs;
  }

  // Points of a pair that was found.
  int num_points(int shape_pair) const {
    int count = -1;
    search_.for_each([&](const NearPair& near) {
      if (near.shape_pair == shape_pair) count = near.points.size();
    });
    return count;
  }
  Frame shape_frame(int shape) const {
    const CollisionShape& of = scene().shapes()[static_cast<std::size_t>(shape)];
    const Frame& body = bodies_.frames[static_cast<std::size_t>(of.body)];
    return {body.pos + body.axes * of.frame.pos, body.axes * of.frame.axes};
  }

  // Pairs with a point nearer than this, each looked at by itself.
  std::vector<int> nearer_than(double gap) {
    const MujocoScope scope;
    std::vector<int> pairs;
    for (std::size_t i = 0; i < scene().shape_pairs().size(); ++i) {
      const ShapePair& shapes = scene().shape_pairs()[i];
      ContactPair fresh;
      ContactPoints points = narrow_phase_.find(static_cast<int>(i), shape_frame(shapes.a),
                                                shape_frame(shapes.b), gap + 0.01, fresh);
      points.keep_below(gap);
      if (!points.empty()) pairs.push_back(static_cast<int>(i));
    }
    return pairs;
  }

 private:
  static std::size_t index(int prop) {
    return static_cast<std::size_t>(scene().body_of_prop(prop));
  }

  BodyStates bodies_;
  test::OneLane lane_;
  PairSearch search_;
  NarrowPhase narrow_phase_;
  ContactMemory memory_;
  std::array<Vec3, 4> velocities_;
};

// The pair of shapes of a prop and the table.
int with_table(int prop) {
  const CollisionScene& scene = World::scene();
  for (std::size_t i = 0; i < scene.shape_pairs().size(); ++i) {
    const ShapePair& pair = scene.shape_pairs()[i];
    const auto body = [&](int shape) {
      return scene
          .bodies()[static_cast<std::size_t>(scene.shapes()[static_cast<std::size_t>(shape)].body)];
    };
    if (body(pair.a).prop == prop && body(pair.b).kind == BodyKind::kStatic) {
      return static_cast<int>(i);
    }
  }
  return -1;
}

// A clearance leaves the search out. Whether it was measured depends on what a slot of the batch
// did before, which must not show.
TEST_CASE("Where the robot is clear of itself, no speed brings its bodies near", "[contact]") {
  World world;
  RandomStream random(11, 0, 0);
  const RobotParams& params = World::model().robot_params();
  const auto of_robot = [](int shape) {
    const CollisionScene& scene = World::scene();
    return scene
        .bodies()[static_cast<std::size_t>(scene.shapes()[static_cast<std::size_t>(shape)].body)]
        .of_robot;
  };
  JointArray qvel;
  qvel.fill(8.0);
  int clear = 0;
  int near = 0;
  for (int i = 0; i < 20000; ++i) {
    JointArray q;
    for (std::size_t joint = 0; joint < kRobotJoints; ++joint) {
      q[joint] = random.uniform(params.lower[joint], params.upper[joint]);
    }
    const RobotPose robot = pose_at(World::model().robot_model(), q.data());
    const JointArray self = World::model().robot_bounds().clearance(robot, {}).self;
    if (*std::ranges::min_element(self) <= 0) continue;
    ++clear;
    world.place_robot(q.data(), qvel);
    world.find();
    for (const int pair : world.found()) {
      const ShapePair& shapes = World::scene().shape_pairs()[static_cast<std::size_t>(pair)];
      if (of_robot(shapes.a) && of_robot(shapes.b)) ++near;
    }
  }
  CHECK(clear > 1000);
  CHECK(near == 0);
}

TEST_CASE("No pair that comes near is missed", "[contact]") {
  constexpr double kGap = 0.002;  // m
  RandomStream random(7, 0, 0);
  const auto vec = [&](double size) {
    const double x = random.uniform(-size, size);
    const double y = random.uniform(-size, size);
    return Vec3(x, y, random.uniform(-size, size));
  };
  int near = 0;
  int come_near = 0;
  World world;
  for (int round = 0; round < 500; ++round) {
    for (int prop = 0; prop < 4; ++prop) {
      const Quat quat(random.normal(), random.normal(), random.normal(), random.normal());
      const bool fixed = prop == test::kBox;
      world.place(prop, Vec3(0, 0.6, 0.08) + vec(0.07), fixed ? Vec3(Vec3::Zero()) : vec(1),
                  quat.normalized());
    }
    std::vector<int> before;
    for (int substep = 0; substep < kSubsteps; ++substep) {
      world.find();
      const std::vector<int> found = world.found();
      const std::vector<int> now = world.nearer_than(kGap);
      for (const int pair : now) {
        REQUIRE(std::count(found.begin(), found.end(), pair) == 1);
        ++near;
        come_near += substep > 0 && std::count(before.begin(), before.end(), pair) == 0 ? 1 : 0;
      }
      before = now;
      world.move();
    }
  }
  CHECK(near > 1000);
  CHECK(come_near > 100);
}

TEST_CASE("Pairs are solved in the order in which they came near, then by their gaps",
          "[contact]") {
  World world;
  world.place(test::kCube1, {0.2, 0.6, 0.020}, Vec3::Zero());
  world.find();
  const int ball = with_table(test::kBall);
  const int first = with_table(test::kCube0);
  const int second = with_table(test::kCube1);
  CHECK(world.found() == std::vector<int>{second});
  // Both come near in the same substep, the ball deeper.
  world.place(test::kCube0, {0, 0.6, 0.0215}, Vec3::Zero());
  world.place(test::kBall, {0.1, 0.6, 0.03}, Vec3::Zero());
  world.find();
  CHECK(world.found() == std::vector<int>{second, ball, first});
  world.place(test::kCube0, {0, 0.6, 0.0195}, Vec3::Zero());
  world.find();
  CHECK(world.found() == std::vector<int>{second, ball, first});
  CHECK(world.remembered() == world.found());
}

// The pair of shapes of a finger's pad, its last box, and the ball.
int with_pad(int link) {
  const CollisionScene& scene = World::scene();
  int last = -1;
  for (std::size_t i = 0; i < scene.shape_pairs().size(); ++i) {
    const ShapePair& pair = scene.shape_pairs()[i];
    const auto body = [&](int shape) {
      return scene
          .bodies()[static_cast<std::size_t>(scene.shapes()[static_cast<std::size_t>(shape)].body)];
    };
    if (body(pair.a).link == link && body(pair.b).prop == test::kBall) last = static_cast<int>(i);
  }
  return last;
}

TEST_CASE("Of two fingers at a ball that is solved first which has been near it for longer",
          "[contact][original]") {
  World world;
  const int left = with_pad(kLeftFingerLink);
  const int right = with_pad(kRightFingerLink);
  const auto pad = [&](int pair) {
    return world.shape_frame(World::scene().shape_pairs()[static_cast<std::size_t>(pair)].a);
  };
  // Beside the open fingers, whose pads are 80 mm apart, nearer to the right one.
  const Mat3 axes = pad(left).axes;
  const Vec3 middle = (pad(left).pos + pad(right).pos) / 2;
  world.place(test::kBall, middle + axes * Vec3(0.06, -0.02, 0), Vec3::Zero());
  world.find();
  CHECK(world.num_points(right) == 0);
  CHECK(world.num_points(left) == -1);
  // Between them, at the left one.
  world.place(test::kBall, middle + axes * Vec3(0, 0.009, 0), Vec3::Zero());
  world.find();
  CHECK(world.num_points(right) == 0);
  CHECK(world.num_points(left) == 1);
  const std::vector<int> order = world.found();
  CHECK(std::ranges::find(order, right) < std::ranges::find(order, left));
  CHECK(world.remembered() == order);
  world.place(test::kBall, middle + axes * Vec3(0, 0, 0.2), Vec3::Zero());
  world.find();
  CHECK(world.remembered().empty());
}

TEST_CASE("Pairs that part are forgotten, those of resting props are not", "[contact]") {
  World world;
  world.place(test::kCube0, {0, 0.6, 0.02}, Vec3::Zero());
  world.place(test::kCube1, {0.2, 0.6, 0.02}, Vec3::Zero());
  world.find();
  REQUIRE(world.remembered().size() == 2);
  world.set_presence(test::kCube0, BodyPresence::kResting);
  world.place(test::kCube1, {0.2, 0.6, 0.2}, Vec3::Zero());
  world.find();
  CHECK(world.found().empty());
  REQUIRE(world.remembered() == std::vector<int>{with_table(test::kCube0)});
  CHECK(world.memory().pairs[0].manifold.known);
  world.set_presence(test::kCube0, BodyPresence::kAbsent);
  world.find();
  CHECK(world.remembered().empty());
}

TEST_CASE("What a search found before leaves no trace in new pairs", "[contact]") {
  const auto stored = [](World& world) {
    world.place(test::kBall, {0.1, 0.6, 0.02}, Vec3::Zero());
    world.find();
    REQUIRE(world.remembered() == std::vector<int>{with_table(test::kBall)});
    std::vector<std::int32_t> ids(StoredPair::kInts);
    std::vector<float> values(StoredPair::kFloats);
    store_pair(world.memory().pairs[0], test::kBall, -1, ids.data(), values.data());
    return std::pair(ids, values);
  };
  World fresh;
  World used;
  used.place(test::kCube0, {0, 0.6, 0.02}, Vec3::Zero());
  used.find();
  REQUIRE(used.memory().pairs[0].manifold.num_points == 4);
  used.place(test::kCube0, {0, 0.6, 1}, Vec3::Zero());
  CHECK(stored(used) == stored(fresh));
}

TEST_CASE("A body that gets faster or wakes within a control step is found", "[contact]") {
  World world;
  world.place(test::kCube0, {0, 0.6, 0.5}, {0, 0, -0.01});
  world.place(test::kCube1, {0.2, 0.6, 0.02}, Vec3::Zero());
  world.set_presence(test::kCube1, BodyPresence::kResting);
  world.find();
  CHECK(world.found().empty());
  world.place(test::kCube0, {0, 0.6, 0.5}, {0, 0, -48});
  world.find();
  world.place(test::kCube0, {0, 0.6, 0.02}, Vec3::Zero());
  world.set_presence(test::kCube1, BodyPresence::kPresent);
  world.find();
  const std::vector<int> both = {with_table(test::kCube0), with_table(test::kCube1)};
  CHECK(world.found() == both);
}

TEST_CASE("A body that is absent touches nothing", "[contact]") {
  World world;
  world.place(test::kCube0, {0, 0.6, 0.02}, Vec3::Zero());
  world.place(test::kCube1, {0.03, 0.6, 0.02}, Vec3::Zero());
  world.set_presence(test::kCube1, BodyPresence::kAbsent);
  world.find();
  CHECK(world.found() == std::vector<int>{with_table(test::kCube0)});
}

}  // namespace
}  // namespace engram
