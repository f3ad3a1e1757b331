#include "tasks/rotate/task.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <numbers>
#include <string>

#include "core/batch/queries.h"
#include "tasks/rotate/peg_angle.h"
#include "tests/env_helpers.h"

namespace engram {
namespace {

using test::make_running, test::row;

constexpr double kPi = std::numbers::pi;

const std::vector<std::string> kIds = {"RotateLenientPos-VLA-v0", "RotateLenientPosNeg-VLA-v0",
                                       "RotateStrictPos-VLA-v0", "RotateStrictPosNeg-VLA-v0"};

TEST_CASE("The lenient reward equals the worked examples", "[rotate]") {
  const auto reward = [](double distance, double error, bool still) {
    tasks::RotateReward in{.distance = distance,
                           .error = error,
                           .robot_static = still,
                           .success = std::abs(error) < 0.1 && still,
                           .success_reward = 60};
    return in.compute();
  };
  CHECK(reward(0.30, 0.8, true) == Approx(0.223130).margin(1e-6));
  CHECK(reward(0.05, 0.8, false) == Approx(5.296714).margin(1e-6));
  CHECK(reward(0.05, 0.05, false) == Approx(19.694953).margin(1e-6));
  CHECK(reward(0.30, 0.05, false) == Approx(5.223130).margin(1e-6));
  CHECK(reward(0.05, 0.05, true) == 60);
  CHECK(reward(0.30, -0.05, true) == 60);
}

TEST_CASE("The strict reward equals the worked examples", "[rotate]") {
  const auto reward = [](double distance, double x, double y, double error, bool still) {
    tasks::RotateReward in{
        .distance = distance,
        .error = error,
        .x_pos_error = x,
        .y_pos_error = y,
        .robot_static = still,
        .success = std::abs(error) < 0.1 && still && std::max(std::abs(x), std::abs(y)) < 0.05,
        .success_reward = 100,
        .strict = true};
    return in.compute();
  };
  CHECK(reward(0.30, 0, 0, 0.8, true) == Approx(0.203285).margin(1e-6));
  CHECK(reward(0.03, 0.01, -0.02, 0.8, false) == Approx(25.463814).margin(1e-6));
  CHECK(reward(0.03, 0.06, 0, 0.05, true) == Approx(9.161057).margin(1e-6));
  CHECK(reward(0.03, 0.01, 0.01, 0.05, false) == Approx(53.262290).margin(1e-6));
  CHECK(reward(0.2, 0.01, 0.01, 0.05, false) == Approx(0.274406).margin(1e-6));
  CHECK(reward(0.2, 0.01, 0.01, 0.05, true) == 100);
}

TEST_CASE("Episodes draw targets and poses over their ranges", "[rotate]") {
  for (const std::string& id : kIds) {
    const BatchOptions options{.num_envs = 3000};
    const auto batch = make_running(id, options);
    const bool both = id.find("PosNeg") != std::string::npos;
    int positive = 0;
    double least = 10;
    double most = -10;
    double max_yaw = 0;
    for (int i = 0; i < options.num_envs; ++i) {
      const double target = *row<double>(test::memory_of(*batch).find("target_angle"), i);
      CHECK(*row<float>(batch->output("task_cue"), i) == static_cast<float>(target));
      CHECK(*row<float>(batch->output("oracle_info"), i) == Approx(target).margin(1e-6));
      positive += target > 0 ? 1 : 0;
      if (both) {
        CHECK((target > 0 ? target > 0.442 : target > -0.443));
      }
      least = std::min(least, target);
      most = std::max(most, target);
      max_yaw = std::max(max_yaw, *row<double>(test::memory_of(*batch).find("initial_yaw"), i));
      const double* pos = batch->state().prop_pos_of(i, 0);
      CHECK(std::max(std::abs(pos[0]), std::abs(pos[1])) <= 0.1);
      CHECK(pos[2] == 0.025);
      CHECK(batch->outputs().success[static_cast<std::size_t>(i)] == 0);
    }
    INFO(id);
    CHECK(max_yaw > 6.2);
    CHECK(std::abs(least) < (both ? 0.443 : 0.102));
    CHECK(most > (both ? 0.784 : 1.565));
    if (both) CHECK(std::abs(positive - 1500) < 150);
    if (!both) CHECK(positive == 3000);
  }
}

TEST_CASE("The target's description says what is drawn", "[rotate]") {
  for (const std::string& id : kIds) {
    const std::string about = make_task(id)->info().random_variables[0].description;
    const bool both = id.find("PosNeg") != std::string::npos;
    CHECK((about.find("drawn from -25.4 to -5.7 or from 25.4 to 45.0 degrees") !=
           std::string::npos) == both);
  }
  const auto task = make_task(kIds[1], {{"angle_threshold", 0.2}});
  CHECK_THAT(task->info().random_variables[0].description,
             Catch::Contains("from -28.2 to -11.5 or from 28.2 to 45.0"));
}

TEST_CASE("Every environment is given its own angle", "[rotate]") {
  const auto batch = make_running("RotateStrictPosNeg-VLA-v0", {.num_envs = 2});
  const std::vector<std::uint8_t> second = {0, 1};
  const std::vector<Pin> pins = {{"target_angle", {-0.2712}}};
  const std::string before = Queries(*batch).instruction(0);
  batch->reset({.mask = second, .seeds = {}, .pins = &pins});
  CHECK(Queries(*batch).instruction(0) == before);
  CHECK(Queries(*batch).instruction(1) ==
        "Rotate the peg by -16 degrees to match the target angle while keeping the center of the "
        "peg in place.");
  CHECK(batch->info().instruction.find("{angle_deg}") != std::string::npos);
}

// Puts the peg somewhere and lets one step pass without physics.
bool succeeds(Batch& batch, double x, double y, double yaw, double joint_speed) {
  const State& state = batch.state();
  double* pos = state.prop_pos_of(0, 0);
  pos[0] = x;
  pos[1] = y;
  double* quat = state.prop_quat_of(0, 0);
  quat[0] = std::cos(yaw / 2);
  quat[3] = std::sin(yaw / 2);
  state.qvel.row(0)[2] = joint_speed;
  test::step(batch, Policy::kZero);
  return batch.outputs().success[0] != 0;
}

TEST_CASE("Success asks for angle, stillness and, if strict, place", "[rotate]") {
  for (const bool strict : {false, true}) {
    const auto batch = make_running(strict ? "RotateStrictPos-VLA-v0" : "RotateLenientPos-VLA-v0",
                                    {.substeps = 0,
                                     .pins = {{"target_angle", {0.5}},
                                              {"initial_yaw", {6.0}},
                                              {"peg_x", {0.02}},
                                              {"peg_y", {-0.03}}}});
    INFO("strict " << strict);
    CHECK_FALSE(succeeds(*batch, 0.02, -0.03, 6.0, 0));
    CHECK(*row<float>(batch->output("y_angle_error"), 0) == Approx(0.5));
    CHECK(succeeds(*batch, 0.02, -0.03, 6.5, 0));
    CHECK(*row<float>(batch->output("relative_angle"), 0) == Approx(0.5));
    CHECK(succeeds(*batch, 0.02, -0.03, 6.5 - 2 * kPi, 0.2));
    CHECK_FALSE(succeeds(*batch, 0.02, -0.03, 6.5, 0.201));
    CHECK(succeeds(*batch, 0.02, -0.03, 6.5 + 0.099, 0));
    CHECK_FALSE(succeeds(*batch, 0.02, -0.03, 6.5 + 0.1001, 0));
    CHECK_FALSE(succeeds(*batch, 0.02, -0.03, 6.5 - 0.1001, 0));
    CHECK(succeeds(*batch, 0.02 + 0.0499, -0.03 - 0.0499, 6.5, 0));  // a square, not a circle
    CHECK(succeeds(*batch, 0.02 + 0.0501, -0.03, 6.5, 0) == !strict);
    CHECK(succeeds(*batch, 0.02, -0.03 - 0.0501, 6.5, 0) == !strict);
    if (strict) CHECK(*row<float>(batch->output("y_pos_error"), 0) == Approx(-0.0501).margin(1e-6));
    CHECK(batch->outputs().terminated[0] == 0);
    CHECK(batch->state_dim() == 33);
    CHECK(batch->outputs().observation[25] == *row<float>(batch->output("oracle_info"), 0));
  }
}

TEST_CASE("A peg that lies still does not creep", "[rotate]") {
  for (const bool sleep : {true, false}) {
    const auto batch = make_running("RotateStrictPos-VLA-v0", {.sleep = sleep});
    const Eigen::Vector3d start = Eigen::Map<Eigen::Vector3d>(batch->state().prop_pos_of(0, 0));
    for (int i = 0; i < 80; ++i) test::step(*batch, Policy::kZero);
    const Eigen::Vector3d end = Eigen::Map<Eigen::Vector3d>(batch->state().prop_pos_of(0, 0));
    CHECK((end - start).head<2>().norm() < 1e-5);
    CHECK(std::abs((end - start).z()) < 2e-4);
    CHECK(std::abs(*row<float>(batch->output("relative_angle"), 0)) < 1e-5F);
  }
}

TEST_CASE("A grasped peg turns with the hand", "[rotate]") {
  const BatchOptions options{.pins = {{"target_angle", {1.5}},
                                      {"initial_yaw", {0}},
                                      {"peg_x", {0}},
                                      {"peg_y", {0}},
                                      {"robot_noise", {0, 0, 0, 0, 0, 0, 0}}}};
  const auto batch = make_running("RotateStrictPos-VLA-v0", options);
  const State& state = batch->state();
  const auto hand_yaw = [&] { return static_cast<double>(batch->outputs().proprio[5]); };
  int turned = 0;
  double lag = 0;
  double offset = 0;
  for (int i = 0; i < 85; ++i) {
    test::step(*batch, Policy::kOracle);
    if (!is_grasping(state, 0, 0)) continue;
    const double between = hand_yaw() - tasks::peg_angle(state.prop_quat_of(0, 0));
    if (++turned == 3) offset = between;
    if (turned > 3) lag = std::max(lag, std::abs(tasks::wrap_angle(between - offset)));
  }
  CHECK(turned > 25);
  CHECK(std::abs(*row<float>(batch->output("y_angle_error"), 0)) < 0.1F);
  CHECK(lag < 0.03);
  CHECK(state.prop_pos_of(0, 0)[2] == Approx(0.025).margin(0.004));
}

}  // namespace
}  // namespace engram
