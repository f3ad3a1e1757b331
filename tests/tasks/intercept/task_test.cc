#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <string>

#include "tasks/intercept/deflect.h"
#include "tasks/intercept/grab.h"
#include "tests/env_helpers.h"

namespace engram {
namespace {

using test::make_running, test::row;
using Vector = Eigen::Vector3d;

const std::map<std::string, std::pair<double, double>> kSpeeds = {
    {"InterceptSlow-VLA-v0", {0.25, 0.5}},       {"InterceptMedium-VLA-v0", {0.5, 0.75}},
    {"InterceptFast-VLA-v0", {0.75, 1.0}},       {"InterceptGrabSlow-VLA-v0", {0.25, 0.5}},
    {"InterceptGrabMedium-VLA-v0", {0.5, 0.75}}, {"InterceptGrabFast-VLA-v0", {0.75, 1.0}}};

bool is_grab(const std::string& id) { return id.find("Grab") != std::string::npos; }

TEST_CASE("The reward of Intercept equals the worked examples", "[intercept]") {
  tasks::InterceptReward in{
      .ball = {-0.2, -0.5, 0.02}, .goal = {0, 0, 0.001}, .tcp = {-0.07, 0, 0.318}};
  double reward = in.compute();
  CHECK(in.tcp_to_hit_pose_dist == Approx(0.656385).margin(1e-6));
  CHECK(reward == Approx(0.270051).margin(1e-6));
  CHECK_FALSE(in.reached);
  in.reached = true;
  reward = in.compute();
  CHECK(reward == Approx(2.540679).margin(1e-6));
  CHECK(in.reached);

  in.reached = false;
  in.ball = {-0.1, -0.2, 0.02};
  in.goal = {0.1, 0, 0.001};
  in.tcp = {-0.15, -0.25, 0.025};
  reward = in.compute();
  CHECK(in.tcp_to_hit_pose_dist == Approx(0.000921).margin(1e-6));
  CHECK(in.reached);
  CHECK(reward == Approx(3.622330).margin(1e-6));
  in.success = true;
  CHECK(in.compute() == 30);
}

TEST_CASE("The reward of InterceptGrab equals the worked examples", "[intercept]") {
  tasks::GrabReward in{.ball = {-0.2, -0.5, 0.02}, .tcp = {-0.07, 0, 0.318}, .gripper_width = 0.08};
  CHECK(in.compute() == Approx(0.543210).margin(1e-6));
  in.ball = {-0.2, -0.1, 0.02};
  in.tcp = {-0.2, -0.09, 0.03};
  CHECK(in.compute() == Approx(123.940290).margin(1e-5));
  in.tcp = in.ball;
  in.gripper_width = 0.05;
  CHECK(in.compute() == Approx(230));
  in.grasped = true;
  in.gripper_width = 0.0401;
  CHECK(in.compute() == Approx(430));
  in.gripper_width = 0.0399;
  CHECK(in.compute() == Approx(240));
  in.success = true;
  CHECK(in.compute() == 300);
}

TEST_CASE("Launches cover their ranges", "[intercept]") {
  for (const auto& [id, speed] : kSpeeds) {
    const BatchOptions options{.num_envs = 2000};
    const auto batch = make_running(id, options);
    Vector low = Vector::Constant(9);
    Vector high = -low;
    Vector slow = low;
    Vector quick = -low;
    for (int i = 0; i < options.num_envs; ++i) {
      const Vector pos = Eigen::Map<Vector>(batch->state().prop_pos_of(i, 0));
      const Vector velocity = Eigen::Map<Vector>(batch->state().prop_qvel_of(i, 0));
      low = low.cwiseMin(pos);
      high = high.cwiseMax(pos);
      slow = slow.cwiseMin(velocity);
      quick = quick.cwiseMax(velocity);
      const float* given = row<float>(batch->output("oracle_info"), i);
      for (int k = 0; k < 3; ++k) REQUIRE(given[k] == static_cast<float>(velocity[k]));
      if (is_grab(id)) continue;
      const double* goal = batch->state().prop_pos_of(i, 1);
      REQUIRE(goal[0] == Approx(pos.x() + 0.2));
      REQUIRE(std::abs(goal[1]) <= 0.2);
      REQUIRE(goal[2] == 0.001);
    }
    INFO(id);
    const double height = is_grab(id) ? 0.02 : 0.04;
    CHECK((low - Vector(-0.35, -0.9, height)).norm() < 0.002);
    CHECK((high - Vector(-0.05, -0.65, height)).norm() < 0.002);
    CHECK((slow - Vector(0, speed.first, 0)).norm() < 0.002);
    CHECK((quick - Vector(0.05, speed.second, 0)).norm() < 0.002);
    CHECK((low - Vector(-0.35, -0.9, height)).minCoeff() >= 0);
    CHECK(batch->state_dim() == (is_grab(id) ? 49 : 50));
  }
}

TEST_CASE("The first observation shows the ball where it starts", "[intercept]") {
  const BatchOptions options{.pins = {{"ball_x", {-0.1}},
                                      {"ball_y", {-0.7}},
                                      {"velocity_x", {0.02}},
                                      {"velocity_y", {0.3}},
                                      {"goal_y", {0.1}}}};
  const auto batch = make_running("InterceptSlow-VLA-v0", options);
  const auto observation = batch->outputs().observation;
  const std::vector<double> expected = {0.1,  0.1, 0.001, -0.1, -0.7, 0.04, 1, 0, 0, 0,
                                        0.02, 0.3, 0,     0.02, 0.3,  0,    0, 0, 0};
  for (std::size_t i = 0; i < expected.size(); ++i) {
    INFO(i);
    CHECK(static_cast<double>(observation[25 + i]) == Approx(expected[i]).margin(1e-6));
  }
  for (std::size_t k = 0; k < 3; ++k) {  // ball minus TCP, goal minus ball
    CHECK(observation[44 + k] == Approx(observation[28 + k] - observation[18 + k]).margin(1e-6));
    CHECK(observation[47 + k] == Approx(observation[25 + k] - observation[28 + k]).margin(1e-6));
  }
  test::step(*batch, Policy::kZero);
  CHECK(batch->outputs().observation[29] == Approx(-0.685).margin(0.001));
}

TEST_CASE("A ball inside the target succeeds, at any speed and height", "[intercept]") {
  const auto batch =
      make_running("InterceptFast-VLA-v0", {.reward_mode = RewardMode::kDense,
                                            .substeps = 0,
                                            .pins = {{"ball_x", {-0.2}}, {"goal_y", {0.0}}}});
  const auto succeeds = [&](double x, double y, double z) {
    double* pos = batch->state().prop_pos_of(0, 0);
    pos[0] = x;
    pos[1] = y;
    pos[2] = z;
    test::step(*batch, Policy::kZero);
    return batch->outputs().success[0] != 0;
  };
  CHECK(succeeds(0.05, 0, 0.02));
  CHECK(batch->outputs().reward[0] == 30);
  CHECK(succeeds(0, -0.0999, 0.3));
  CHECK_FALSE(succeeds(0, -0.1001, 0.02));
  CHECK_FALSE(succeeds(0.08, 0.08, 0.02));
  CHECK(batch->outputs().terminated[0] == 0);
  CHECK(*row<std::uint8_t>(batch->output("success_once"), 0) == 1);
}

TEST_CASE("Having been behind the ball is remembered for the episode", "[intercept]") {
  BatchOptions options{.reward_mode = RewardMode::kDense, .substeps = 0};
  options.pins = {{"ball_y", {-0.65}}, {"goal_y", {-0.2}}};  // 0.49 m apart
  const auto batch = make_running("InterceptSlow-VLA-v0", options);
  double* ball = batch->state().prop_pos_of(0, 0);
  const Vector start = Eigen::Map<Vector>(ball);
  test::step(*batch, Policy::kZero);
  CHECK(batch->outputs().reward[0] < 2);
  // The ball where the hand is right behind it, then far away again.
  const Vector goal = Eigen::Map<Vector>(batch->state().prop_pos_of(0, 1));
  const Vector tcp = Eigen::Map<Vector>(batch->state().tcp_pos.row(0));
  const Vector there = tcp - 0.07 * (tcp - goal).normalized();
  std::copy_n(there.data(), 3, ball);
  test::step(*batch, Policy::kZero);
  CHECK(batch->outputs().reward[0] > 2);
  std::copy_n(start.data(), 3, ball);
  test::step(*batch, Policy::kZero);
  CHECK(batch->outputs().reward[0] > 2);
  CHECK(row<float>(batch->output("reward_dict"), 0)[1] == 1);  // of the step before
  batch->reset();
  test::step(*batch, Policy::kZero);
  CHECK(batch->outputs().reward[0] < 2);
}

TEST_CASE("The reward term robot_static_reward of InterceptGrab is a condition", "[intercept]") {
  const auto batch = make_running("InterceptGrabFast-VLA-v0");
  constexpr int kTerm = 9;  // in docs/tasks/intercept.md
  const auto reported = [&] { return row<float>(batch->output("reward_dict"), 0)[kTerm]; };
  const auto is_static = [&] { return *row<std::uint8_t>(batch->output("is_robot_static"), 0); };
  test::step(*batch, Policy::kZero);
  for (const float speed : {0.0F, 1.0F, 1.0F, 0.0F, 0.0F, 0.0F}) {
    const float before = is_static();
    batch->step(std::vector<float>{speed, 0, 0, 0, 0, 0, 1});
    CHECK(reported() == before);
  }
}

TEST_CASE("The TCP's velocity is that of its motion", "[intercept]") {
  const auto batch = make_running("InterceptGrabFast-VLA-v0");
  for (int i = 0; i < 3; ++i) batch->step(std::vector<float>{1, 0.5F, -0.5F, 0, 0, 0, 1});
  const auto observation = batch->outputs().observation;
  Vector velocity;  // of the TCP: the ball's minus the relative one
  for (int k = 0; k < 3; ++k) {
    velocity[k] = static_cast<double>(observation[static_cast<std::size_t>(36 + k)] -
                                      observation[static_cast<std::size_t>(46 + k)]);
  }
  ArmJacobian jacobian;
  const double* qpos = batch->state().qpos.row(0);
  ArmVector ahead = Eigen::Map<const ArmVector>(qpos);
  constexpr double kMoment = 1e-6;
  ahead += kMoment * Eigen::Map<const ArmVector>(batch->state().qvel.row(0));
  const Arm& arm = batch->physics_model().arm();
  const Vector moved = (arm.forward(ahead.data()).pos - arm.forward(qpos).pos) / kMoment;
  CHECK(velocity.norm() > 0.3);
  CHECK((velocity - moved).norm() < 1e-4);
  CHECK(observation[45] == Approx(0.08).margin(1e-3));
}

TEST_CASE("A caught ball stays caught, and the fingers do not sink in", "[intercept]") {
  for (const auto& [id, speed] : kSpeeds) {
    if (!is_grab(id)) continue;
    const BatchOptions options{.num_envs = 8};
    const auto batch = make_running(id, options);
    int held = 0;
    for (int step = 0; step < 58; ++step) {
      test::step(*batch, Policy::kOracle);
      for (int i = 0; i < options.num_envs; ++i) {
        if (batch->outputs().success[static_cast<std::size_t>(i)] == 0 || step < 50) continue;
        ++held;
        const double* fingers = batch->state().qpos.row(i) + kArmJoints;
        const double* qvel = batch->state().prop_qvel_of(i, 0);
        CHECK(fingers[0] + fingers[1] == Approx(2 * 0.01771).margin(1e-4));  // as the original's
        CHECK(std::hypot(qvel[0], qvel[1], qvel[2]) < 0.01);
      }
    }
    INFO(id);
    CHECK(held >= 40);
  }
}

TEST_CASE("Who does nothing hardly ever succeeds", "[intercept]") {
  const auto share = [](const char* id) {
    BatchOptions options{.num_envs = 2000};
    options.seed = 10'000;
    const auto batch = make_running(id, options);
    for (int i = 0; i < 60; ++i) test::step(*batch, Policy::kZero);
    const std::uint8_t* once = row<std::uint8_t>(batch->output("success_once"), 0);
    return static_cast<double>(std::count(once, once + options.num_envs, 1)) / options.num_envs;
  };
  const double slow = share("InterceptSlow-VLA-v0");  // 0.56 %
  CHECK(slow > 0.002);
  CHECK(slow < 0.010);
  CHECK(share("InterceptMedium-VLA-v0") == 0);  // 0.01 %
}

}  // namespace
}  // namespace engram
