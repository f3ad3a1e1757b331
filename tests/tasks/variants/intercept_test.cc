// Intercept and InterceptGrab with other constants: what follows from each, and sets that are
// refused.
#include <catch2/catch.hpp>
#include <numbers>

#include "tasks/intercept/deflect.h"
#include "tasks/intercept/grab.h"
#include "tests/tasks/variants/constant_text.h"
#include "tests/tasks/variants/moved_props.h"

namespace engram {
namespace {

using Catch::Contains, test::make_env, test::make_running;

constexpr const char* kIds[] = {"InterceptSlow-VLA-v0", "InterceptGrabSlow-VLA-v0"};
constexpr int kBall = 0;

TEST_CASE("The range of speeds is where launches are drawn", "[variants][intercept]") {
  for (const char* id : kIds) {
    const MakeOptions options{{.num_envs = 200}, {{"VELOCITY_RANGE", ConstantList{0.6, 0.62}}}};
    const auto batch = make_env(id, options);
    CHECK(test::constant_text(batch->info(), "VELOCITY_RANGE") == "[0.6, 0.62]");
    CHECK(test::draw_of(batch->info(), "velocity_y").low == 0.6);
    CHECK(test::draw_of(batch->info(), "velocity_y").high == 0.62);
    batch->reset();
    double least = 9;
    double most = 0;
    for (int i = 0; i < options.num_envs; ++i) {
      const double speed = batch->state().prop_qvel_of(i, kBall)[1];
      least = std::min(least, speed);
      most = std::max(most, speed);
    }
    CHECK((least >= 0.6 && least < 0.601));
    CHECK((most <= 0.62 && most > 0.619));
    const ConstantTable narrow = {{"VELOCITY_RANGE", ConstantList{0.61, 0.61}}};
    batch->reset({.mask = {}, .seeds = {}, .pins = nullptr, .constants = &narrow});
    CHECK(batch->state().prop_qvel_of(7, kBall)[1] == Approx(0.61));
  }
}

// The value of the benchmark's base classes.
TEST_CASE("A range of speeds of 0, 0 means a ball at rest", "[variants][intercept]") {
  for (const char* id : kIds) {
    INFO(id);
    const MakeOptions options{{.num_envs = 8}, {{"VELOCITY_RANGE", ConstantList{0.0, 0.0}}}};
    const auto batch = make_env(id, options);
    CHECK(test::draw_of(batch->info(), "velocity_x").high == 0);
    CHECK(test::draw_of(batch->info(), "velocity_y").high == 0);
    batch->reset();
    const auto ball = [&](int i) {
      return Eigen::Map<const Eigen::Vector3d>(batch->state().prop_pos_of(i, kBall));
    };
    std::vector<Eigen::Vector3d> starts;
    for (int i = 0; i < options.num_envs; ++i) {
      starts.emplace_back(ball(i));
      CHECK(batch->state().prop_qvel_of(i, kBall)[0] == 0);
      CHECK(batch->state().prop_qvel_of(i, kBall)[1] == 0);
    }
    for (int step = 0; step < 50; ++step) test::step(*batch, Policy::kZero);
    for (int i = 0; i < options.num_envs; ++i) {
      CHECK((ball(i) - starts[static_cast<std::size_t>(i)]).head<2>().norm() < 1e-6);
    }
  }
}

TEST_CASE("A range of speeds may begin with 0", "[variants][intercept]") {
  for (const char* id : kIds) {
    const auto batch =
        make_running(id, MakeOptions{{.pins = {{"velocity_y", {0.0}}, {"velocity_x", {0.04}}}},
                                     {{"VELOCITY_RANGE", ConstantList{0.0, 0.5}}}});
    CHECK(batch->state().prop_qvel_of(0, kBall)[0] == 0.04);
    CHECK(batch->state().prop_qvel_of(0, kBall)[1] == 0);
  }
}

TEST_CASE("The ball is as large and as heavy as its radius says", "[variants][intercept]") {
  for (const char* id : kIds) {
    for (const double radius : {0.012, 0.02, 0.03}) {
      const ConstantTable constants = {{"BALL_RADIUS", radius}};
      const std::string document = make_task(id, constants)->document();
      CHECK(test::size_in(document, "ball") == radius);
      CHECK(test::mass_in(document, "ball") ==
            Approx(4000.0 / 3 * std::numbers::pi * radius * radius * radius));
      const auto batch = test::make_still(id, constants);
      const bool falls = id == kIds[0];
      CHECK(batch->state().prop_pos_of(0, kBall)[2] == (falls ? 2 : 1) * radius);
    }
  }
}

TEST_CASE("Rewards know the ball's radius", "[variants][intercept]") {
  tasks::InterceptReward in{
      .ball = {0, 0, 0.03}, .goal = {1, 0, 0.03}, .tcp = {-0.08, 0, 0.03}, .ball_radius = 0.03};
  in.compute();
  CHECK(in.tcp_to_hit_pose_dist == Approx(0).margin(1e-12));
  in.ball_radius = 0.02;
  in.compute();
  CHECK(in.tcp_to_hit_pose_dist == Approx(0.01));

  tasks::GrabReward grab;
  grab.gripper_width = 0.07;  // too wide for a ball of 2 cm, not for one of 3 cm
  grab.ball_radius = 0.02;
  const double wide = grab.compute();
  grab.ball_radius = 0.03;
  CHECK(grab.compute() > wide + 90);
  grab.gripper_width = 0.05;  // narrower than the ball
  grab.compute();
  CHECK_FALSE(grab.in_gripper);
}

TEST_CASE("The target is as forgiving as its radius says", "[variants][intercept]") {
  for (const double radius : {0.02, 0.05, 0.2}) {
    const ConstantTable constants = {{"GOAL_RADIUS", radius}};
    CHECK(test::size_in(make_task(kIds[0], constants)->document(), "goal_region") == radius);
    const auto batch =
        test::make_still(kIds[0], constants, {{"ball_x", {-0.2}}, {"goal_y", {0.1}}});
    CHECK(test::succeeds_with(*batch, kBall, radius - 1e-6, 0.1, 0.02));
    CHECK(batch->outputs().reward[0] == 30);
    CHECK_FALSE(test::succeeds_with(*batch, kBall, radius + 1e-6, 0.1, 0.02));
  }
}

TEST_CASE("Coefficients make abrupt actions cost where the original's weigh nothing",
          "[variants][intercept]") {
  for (const char* id : kIds) {
    const float usual = test::dense_reward_of(id, {});
    // |a| = 1: tanh 2.
    CHECK(test::dense_reward_of(id, {{"ACTION_L2_COEF", 0.1}}) ==
          Approx(usual - 0.1 * std::tanh(2.0)).margin(1e-6));
    CHECK(test::constant_text(make_task(id, {{"QVEL_L2_COEF", 0.1}})->info(), "QVEL_L2_COEF") ==
          "0.1");
  }
}

TEST_CASE("Balls that come too late, or do not fit the hand, are refused",
          "[variants][intercept]") {
  for (const char* id : kIds) {
    CHECK_THROWS_WITH(make_task(id, {{"VELOCITY_RANGE", ConstantList{0.2, 0.3}}}),
                      Contains("55 + 15 to act = 70 control steps") && Contains("60"));
    CHECK_NOTHROW(
        make_task(id, {{"VELOCITY_RANGE", ConstantList{0.2, 0.3}}, {"max_episode_steps", 70}}));
    CHECK_THROWS_WITH(make_task(id, {{"VELOCITY_RANGE", ConstantList{0.05, 0.5}}}),
                      Contains("219 + 15 to act"));
    CHECK_THROWS_WITH(make_task(id, {{"VELOCITY_RANGE", ConstantList{-0.1, 0.0}}}),
                      Contains("0 to 1.5"));
    CHECK_THROWS_WITH(make_task(id, {{"max_episode_steps", 58}}), Contains("44 + 15 to act"));
    CHECK_THROWS_WITH(make_task(id, {{"BALL_RADIUS", 0.031}}), Contains("0.012 to 0.03"));
    CHECK_THROWS_WITH(make_task(id, {{"VELOCITY_RANGE", ConstantList{0.5, 0.3}}}),
                      Contains("VELOCITY_RANGE"));
  }
  CHECK_THROWS_WITH(make_task(kIds[1], {{"GOAL_RADIUS", 0.1}}), Contains("GOAL_RADIUS"));
}

}  // namespace
}  // namespace engram
