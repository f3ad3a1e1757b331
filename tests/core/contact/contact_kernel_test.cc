// Kernels of all widths against one another: environments with robots, free bodies and patches at
// random, side by side in every combination.
#include "core/contact/contact_kernel.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <vector>

#include "core/contact/contact_block.h"
#include "core/robot/lane_block.h"
#include "tests/core/robot/robot_fixture.h"
#include "tests/core/scene/props.h"

namespace engram::test {
namespace {

constexpr int kBodies = 3;

// One environment at a substep's start.
struct Environment {
  Robot robot;
  std::vector<FreeBodyState> bodies;
  std::vector<PatchSpec> patches;
};

// All numbers that a substep gives: joints, bodies, impulses, which patches slip.
using Result = std::vector<double>;

const PhysicsModel& model() { return mixed_model(); }
Vec3 base_position() { return Eigen::Map<const Vec3>(model().robot_model().base_position); }
const FreeBody& body_of(int slot) {
  constexpr int kProps[kBodies] = {kCube0, kBall, kCube1};
  return model().props()[static_cast<std::size_t>(kProps[slot])].body;
}

class Generator {
 public:
  explicit Generator(std::uint64_t seed) : random_(seed, 0, 0) {}

  Vec3 vec(double size) {
    const double x = random_.uniform(-size, size);
    const double y = random_.uniform(-size, size);
    return {x, y, random_.uniform(-size, size)};
  }
  int below(int count) { return std::min(static_cast<int>(random_.uniform(0, count)), count - 1); }

  // Some environments have neither bodies nor patches, some have bodies alone.
  Environment environment() {
    Environment result;
    result.robot = random_robot(random_);
    const int bodies = below(kBodies + 1);
    for (int slot = 0; slot < bodies; ++slot) result.bodies.push_back(body());
    const int patches = bodies == 0 ? below(3) : below(8);
    for (int i = 0; i < patches; ++i) add_patch(result);
    return result;
  }

 private:
  FreeBodyState body() {
    FreeBodyState state;
    state.center = vec(0.2);
    state.quat =
        Quat(1 + random_.uniform(0, 1), random_.normal(), random_.normal(), random_.normal())
            .normalized();
    state.linear = vec(0.3);
    state.angular = vec(3);
    return state;
  }

  void add_patch(Environment& to) {
    const int bodies = static_cast<int>(to.bodies.size());
    PatchSpec spec;
    const int kind = bodies == 0 ? 0 : below(bodies == 1 ? 3 : 4);
    switch (kind) {
      case 0: {  // a link and the table, which the first one cannot reach
        spec.link_a = 1 + below(kNumLinks - 1);
        const int finger = finger_of(spec.link_a);
        const int joint = finger >= 0 ? kArmJoints + finger : hinges_of(spec.link_a) - 1;
        spec.list = PatchLists::kLinks + joint;
        break;
      }
      case 1:  // a body and the table, or a kinematic prop
        spec.body_a = below(bodies);
        spec.list = PatchLists::kFixed;
        spec.kinematic_velocity = below(2) == 0 ? Vec3(Vec3::Zero()) : vec(0.2);
        break;
      case 2:  // a link and a body
        spec.link_a = below(2) == 0 ? kLeftFingerLink : kHandLink;
        spec.body_b = below(bodies);
        spec.list = PatchLists::kMoving;
        break;
      default:  // two bodies
        spec.body_a = below(bodies);
        spec.body_b = (spec.body_a + 1) % bodies;
        spec.list = PatchLists::kMoving;
    }
    add_points(to, spec);
    to.patches.push_back(spec);
  }

  void add_points(const Environment& to, PatchSpec& spec) {
    const int slot = std::max(spec.body_a, spec.body_b);
    const Vec3 middle =
        slot >= 0 ? to.bodies[static_cast<std::size_t>(slot)].center : Vec3(vec(0.3));
    const bool rubber = below(2) == 0;
    spec.friction = rubber ? 1.15 : 0.3;
    spec.torsion_radius = rubber ? 0.1 : 0;
    spec.normal = (vec(1) + Vec3(0, 0, 1.2)).normalized();
    spec.num_points = 1 + below(kPatchPoints);
    for (int i = 0; i < spec.num_points; ++i) {
      const auto k = static_cast<std::size_t>(i);
      spec.points[k] = middle + vec(0.03);
      spec.gaps[k] = random_.uniform(-0.001, 0.002);
    }
    spec.num_anchors = below(kPatchAnchors + 1);
    for (int i = 0; i < spec.num_anchors; ++i) {
      const auto k = static_cast<std::size_t>(i);
      spec.anchors_a[k] = middle + vec(0.03);
      spec.anchors_b[k] = spec.anchors_a[k] + vec(0.0005);
    }
  }

  RandomStream random_;
};

std::vector<Environment> environments(int count, std::uint64_t seed = 3) {
  Generator generator(seed);
  std::vector<Environment> result;
  for (int i = 0; i < count; ++i) result.push_back(generator.environment());
  return result;
}

// A block of lanes of one width, used again and again.
class Lanes {
 public:
  explicit Lanes(int width) : Lanes(contact_kernel(width)) {}
  explicit Lanes(const ContactKernel& kernel)
      : kernel_(kernel),
        robots_(*lane_kernel(kernel.lanes)),
        contacts_(kernel.lanes, kBodies, kBodies, base_position()) {}

  int width() const { return robots_.lanes(); }

  // One substep of as many environments as there are lanes.
  std::vector<Result> step(const std::vector<const Environment*>& environments) {
    contacts_.clear();
    std::vector<std::vector<int>> patches;
    for (int lane = 0; lane < width(); ++lane) {
      const Environment& environment = *environments[static_cast<std::size_t>(lane)];
      put(lane, environment);
      patches.emplace_back();
      for (const PatchSpec& spec : environment.patches) {
        patches.back().push_back(contacts_.add_patch(lane, spec));
      }
    }
    kernel_.substep(model().robot_model(), model().robot_params(), false, robots_.vectors(),
                    contacts_.view());
    std::vector<Result> results;
    for (int lane = 0; lane < width(); ++lane) {
      const auto i = static_cast<std::size_t>(lane);
      results.push_back(get(lane, *environments[i], patches[i]));
    }
    return results;
  }

 private:
  void put(int lane, const Environment& environment) {
    robots_.put(LaneVectors::kQ, lane, environment.robot.q.data(), kRobotJoints);
    robots_.put(LaneVectors::kV, lane, environment.robot.v.data(), kRobotJoints);
    for (int i = 0; i < kRobotJoints; ++i) {
      const double bias = drive_bias_of(environment.robot, i);
      robots_.put(LaneVectors::kDriveBias + i, lane, &bias, 1);
    }
    for (std::size_t slot = 0; slot < environment.bodies.size(); ++slot) {
      const int i = static_cast<int>(slot);
      contacts_.put_body(lane, i, body_of(i), environment.bodies[slot]);
    }
  }

  Result get(int lane, const Environment& environment, const std::vector<int>& patches) const {
    Result result(2 * kRobotJoints);
    robots_.get(LaneVectors::kEndQ, lane, result.data(), 2 * kRobotJoints);
    const auto append = [&](const auto& values) {
      for (int i = 0; i < values.size(); ++i) result.push_back(values[i]);
    };
    for (std::size_t slot = 0; slot < environment.bodies.size(); ++slot) {
      FreeBodyState state = environment.bodies[slot];
      contacts_.get_body(lane, static_cast<int>(slot), state);
      append(state.center);
      append(state.quat.coeffs());
      append(state.linear);
      append(state.angular);
    }
    for (const int patch : patches) {
      result.push_back(patch);
      if (patch < 0) continue;
      result.push_back(contacts_.is_slipping(lane, patch) ? 1 : 0);
      append(contacts_.impulse(lane, patch));
    }
    return result;
  }

  const ContactKernel& kernel_;
  LaneBlock robots_;
  ContactBlock contacts_;
};

std::vector<Result> alone(const std::vector<Environment>& environments) {
  Lanes lane(baseline_single_contact_kernel());
  std::vector<Result> results;
  for (const Environment& environment : environments) {
    results.push_back(lane.step({&environment}).front());
  }
  return results;
}

bool same(const Result& a, const Result& b) {
  return a.size() == b.size() && same_bits(a.data(), b.data(), static_cast<int>(a.size()));
}

TEST_CASE("Environments in contact give the same bits in lanes of every width", "[contact]") {
  const std::vector<Environment> all = environments(512);
  const std::vector<Result> expected = alone(all);
  std::vector<const ContactKernel*> kernels;
  for (const int width : {1, 4, 8, 16}) {
    if (lane_kernel(width) != nullptr) kernels.push_back(&contact_kernel(width));
  }
  for (const ContactKernel* kernel : kernels) {
    const int width = kernel->lanes;
    CAPTURE(width);
    Lanes lanes(*kernel);
    int different = 0;
    for (std::size_t first = 0; first < all.size(); first += static_cast<std::size_t>(width)) {
      std::vector<const Environment*> together;
      for (int lane = 0; lane < width; ++lane) {
        together.push_back(&all[first + static_cast<std::size_t>(lane)]);
      }
      const std::vector<Result> results = lanes.step(together);
      for (std::size_t lane = 0; lane < results.size(); ++lane) {
        different += same(results[lane], expected[first + lane]) ? 0 : 1;
      }
    }
    CHECK(different == 0);
  }
}

TEST_CASE("An environment's bits depend neither on its lane nor on its neighbours", "[contact]") {
  const std::vector<Environment> all = environments(64, 4);
  const std::vector<Result> expected = alone(all);
  const Environment empty{all.front().robot, {}, {}};
  Lanes lanes(widest_lane_kernel().lanes);
  Generator generator(5);
  int different = 0;
  for (std::size_t i = 0; i < all.size(); ++i) {
    for (int lane = 0; lane < lanes.width(); ++lane) {
      std::vector<const Environment*> together;
      for (int k = 0; k < lanes.width(); ++k) {
        const int other = generator.below(2 * static_cast<int>(all.size()));
        together.push_back(
            other < static_cast<int>(all.size()) ? &all[static_cast<std::size_t>(other)] : &empty);
      }
      const auto here = static_cast<std::size_t>(lane);
      together[here] = &all[i];
      different += same(lanes.step(together)[here], expected[i]) ? 0 : 1;
    }
  }
  CHECK(different == 0);
}

TEST_CASE("Contacts of all kinds act in these environments", "[contact]") {
  const std::vector<Environment> all = environments(512);
  const std::vector<Result> with = alone(all);
  int pushed = 0;
  int empty = 0;
  for (std::size_t i = 0; i < all.size(); ++i) {
    Environment without = all[i];
    without.patches.clear();
    const Result free = alone({without}).front();
    const auto numbers = static_cast<int>(free.size());
    pushed += same_bits(free.data(), with[i].data(), numbers) ? 0 : 1;
    empty += all[i].bodies.empty() && all[i].patches.empty() ? 1 : 0;
    REQUIRE(std::all_of(with[i].begin(), with[i].end(),
                        [](double value) { return std::abs(value) < 1e4; }));
  }
  CHECK(pushed > 250);
  CHECK(empty > 20);
}

TEST_CASE("A robot that touches nothing moves as without contacts, to the bit", "[contact]") {
  const LaneKernel& kernel = widest_lane_kernel();
  const std::vector<Robot> robots = random_robots(64);
  const auto put = [](LaneBlock& block, int lane, const Robot& robot) {
    block.put(LaneVectors::kQ, lane, robot.q.data(), kRobotJoints);
    block.put(LaneVectors::kV, lane, robot.v.data(), kRobotJoints);
    for (int i = 0; i < kRobotJoints; ++i) {
      const double bias = drive_bias_of(robot, i);
      block.put(LaneVectors::kDriveBias + i, lane, &bias, 1);
    }
  };
  LaneBlock free(kernel);
  LaneBlock busy(kernel);
  ContactBlock contacts(kernel.lanes, kBodies, kBodies, base_position());
  for (std::size_t first = 0; first < robots.size();
       first += static_cast<std::size_t>(kernel.lanes)) {
    contacts.clear();
    for (int lane = 0; lane < kernel.lanes; ++lane) {
      const Robot& robot = robots[first + static_cast<std::size_t>(lane)];
      put(free, lane, robot);
      put(busy, lane, robot);
    }
    // A body that hovers in one of the lanes.
    FreeBodyState state;
    state.linear = {0.1, -0.2, 0.3};
    contacts.put_body(1, 0, body_of(0), state);
    kernel.substep(model().robot_model(), model().robot_params(), false, free.vectors());
    contact_kernel(kernel.lanes)
        .substep(model().robot_model(), model().robot_params(), false, busy.vectors(),
                 contacts.view());
    REQUIRE(same_bits(free.vectors() + LaneVectors::kEndQ * kernel.lanes,
                      busy.vectors() + LaneVectors::kEndQ * kernel.lanes,
                      2 * kRobotJoints * kernel.lanes));
    contacts.get_body(1, 0, state);
    REQUIRE(state.center.isApprox(0.01 * Vec3(0.1, -0.2, 0.3), 1e-6));
  }
}

TEST_CASE("Kernels exist for the widths that robots have", "[contact]") {
  for (const int width : {1, 4, 8, 16}) {
    if (lane_kernel(width) != nullptr) CHECK(contact_kernel(width).lanes == width);
  }
  CHECK(baseline_single_contact_kernel().lanes == 1);
}

}  // namespace
}  // namespace engram::test
