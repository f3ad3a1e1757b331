// GatherAndRecall as users see it: scene, flash, buttons and observations.
#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "core/batch/queries.h"
#include "core/batch/snapshot.h"
#include "tasks/common/tcp_servo.h"
#include "tasks/gather_and_recall/reward.h"
#include "tests/env_helpers.h"

namespace engram {
namespace {

using test::flag, test::make_env, test::make_running, test::row;

const Eigen::Vector3d kDisc(0.04, 0.14, 0.026);
constexpr double kUpright[4] = {1, 0, 0, 0};

std::unique_ptr<Batch> start(int cubes, double color, double trigger, double duration = 8) {
  const BatchOptions options{
      .auto_reset = AutoReset::kOff,
      .pins = {{"disc_x", {0.04}},
               {"disc_y", {0.14}},
               {"flash_color", {color}},
               {"flash_trigger_count", {trigger}},
               {"flash_duration", {duration}},
               {"cube_jitter", std::vector<double>(static_cast<std::size_t>(2 * cubes))}}};
  return make_running("GatherAndRecall" + std::to_string(cubes) + "-VLA-v0", options);
}

int number(const Batch& batch, const char* name) {
  return *row<std::int32_t>(batch.output(name), 0);
}
Eigen::Vector3d goal(const Batch& batch) {
  return Eigen::Map<const Eigen::Vector3f>(row<float>(batch.output("obj_to_goal_pos"), 0))
      .cast<double>();
}
Eigen::Vector3d tcp(const Batch& batch) {
  return Eigen::Map<const Eigen::Vector3d>(batch.state().tcp_pos.row(0));
}
void idle(Batch& batch, int steps = 1) {
  for (int i = 0; i < steps; ++i) test::step(batch, Policy::kZero);
}
void put_on_disc(const Batch& batch, int cube) {
  const Eigen::Vector3d place = kDisc + Eigen::Vector3d(0.06 * (cube - 1), 0, 0);
  batch.state().place_prop(0, cube, place.data(), kUpright);
}
void move(Batch& batch, const Eigen::Vector3d& to, int steps) {
  std::vector<float> action(7);
  for (int i = 0; i < steps && batch.state().finished[0] == 0; ++i) {
    tasks::servo_tcp(batch.state(), 0, to, tasks::kToolDown, tasks::kGripperClosed, action.data());
    batch.step(action);
  }
}

TEST_CASE("Cubes, disc and buttons stand where they should", "[gather]") {
  const auto batch = start(5, 0, 1);
  const State& state = batch->state();
  CHECK(Eigen::Map<const Eigen::Vector3d>(state.prop_pos_of(0, 3))
            .isApprox(Eigen::Vector3d(-0.085, -0.215, 0.02)));
  CHECK(Eigen::Map<const Eigen::Vector3d>(state.prop_pos_of(0, 5))
            .isApprox(Eigen::Vector3d(0.04, 0.14, 0.003)));
  // red, green and blue: base and cap each
  for (int color = 0; color < 3; ++color) {
    const double* cap = state.prop_pos_of(0, 7 + 2 * color);
    CHECK(cap[0] == Approx(-0.18));
    CHECK(cap[1] == Approx(0.14 * color).margin(1e-12));
    CHECK(cap[2] == Approx(0.044));
  }
  CHECK(number(*batch, "pressed_button") == -1);
  const int dims[] = {49, 65, 81, 97, 113};
  for (int i = 0; i < 5; ++i) {
    CHECK(make_env("GatherAndRecall" + std::to_string(2 * i + 1) + "-VLA-v0")->state_dim() ==
          dims[i]);
  }
}

TEST_CASE("The flash lasts its steps, begins with the cube that triggers it and comes once",
          "[gather]") {
  const auto batch = start(3, 2, 2, 9);
  CHECK(Queries(*batch).cue_end(0) == batch->info().horizon);
  idle(*batch, 3);
  put_on_disc(*batch, 0);
  idle(*batch, 3);
  CHECK(number(*batch, "n_on_disc") == 1);
  CHECK_FALSE(flag(*batch, "flash_triggered"));
  put_on_disc(*batch, 1);
  std::vector<int> lit;
  const int bulb = batch->state().num_props - 1;
  for (int i = 0; i < 20; ++i) {
    idle(*batch);
    const bool active = flag(*batch, "flash_active");
    if (active) lit.push_back(batch->state().elapsed[0]);
    CHECK((batch->state().prop_emission.row(0)[bulb] > 0) == active);
    const float* rgba = batch->state().prop_rgba.row(0) + 4 * bulb;
    CHECK((rgba[0] == 0) == active);  // blue against white
  }
  CHECK(lit == std::vector<int>{7, 8, 9, 10, 11, 12, 13, 14, 15});
  CHECK(Queries(*batch).cue_end(0) == 16);
}

TEST_CASE("Cubes that left the disc stay counted, but no longer all are there", "[gather]") {
  const auto batch = start(3, 0, 1);
  for (int cube = 0; cube < 3; ++cube) put_on_disc(*batch, cube);
  idle(*batch);
  CHECK(flag(*batch, "all_on_disc"));
  const double away[3] = {-0.2, -0.3, 0.02};
  batch->state().place_prop(0, 1, away, kUpright);
  idle(*batch);
  CHECK(number(*batch, "n_on_disc") == 3);
  CHECK_FALSE(flag(*batch, "all_on_disc"));
  CHECK(goal(*batch).norm() == 0);
}

TEST_CASE("The goal vector leads from cube to disc to button", "[gather]") {
  const auto batch = start(3, 1, 1);
  Eigen::Vector3d nearest(0, 0, 0);
  double least = 10;
  for (int cube = 0; cube < 3; ++cube) {
    const Eigen::Map<const Eigen::Vector3d> at(batch->state().prop_pos_of(0, cube));
    if ((at - tcp(*batch)).norm() < least) {
      least = (at - tcp(*batch)).norm();
      nearest = at;
    }
  }
  CHECK((goal(*batch) - (nearest - tcp(*batch))).norm() < 1e-6);
  const Eigen::Vector3d beside = tcp(*batch) + Eigen::Vector3d(0, 0.03, 0);
  batch->state().place_prop(0, 0, beside.data(), kUpright, PropStatus::kAwake);
  idle(*batch);
  CHECK((goal(*batch) - (kDisc - tcp(*batch))).norm() < 1e-6);
  for (int cube = 0; cube < 3; ++cube) put_on_disc(*batch, cube);
  idle(*batch);
  CHECK((goal(*batch) - (Eigen::Vector3d(-0.18, 0.14, 0.063) - tcp(*batch))).norm() < 1e-6);
}

TEST_CASE("The right button solves it, a wrong one fails and ends the episode", "[gather]") {
  for (int color = 0; color < 3; ++color) {
    const auto batch = start(3, color, 1);
    // Too early: nothing happens.
    const Eigen::Vector3d over(-0.18, 0.14, 0.12);
    const Eigen::Vector3d down(-0.18, 0.14, 0.072);
    move(*batch, over, 25);
    move(*batch, down, 15);
    CHECK(number(*batch, "pressed_button") == -1);
    CHECK_FALSE(flag(*batch, "answered"));
    CHECK(batch->state().prop_pos_of(0, 7)[2] == Approx(0.030).margin(2e-3));  // the cap gives way
    move(*batch, over, 15);
    for (int cube = 0; cube < 3; ++cube) put_on_disc(*batch, cube);
    idle(*batch, 2);
    move(*batch, down, 15);
    CHECK(number(*batch, "pressed_button") == 1);
    CHECK(flag(*batch, "success") == (color == 1));
    CHECK(flag(*batch, "failed") == (color != 1));
    CHECK(flag(*batch, "answered"));
    CHECK(number(*batch, "first_answer") == 1);
    CHECK(flag(*batch, "first_answer_correct") == (color == 1));
    CHECK(*row<std::uint8_t>(batch->output("terminated"), 0) == 1);
    CHECK(batch->outputs().reward[0] == (color == 1 ? 1.0F : -0.5F));
  }
}

TEST_CASE("Cubes that were carried onto the disc lie still on it", "[gather]") {
  const auto batch = start(3, 0, 1);
  for (int i = 0; i < batch->info().horizon && batch->state().finished[0] == 0; ++i) {
    test::step(*batch, Policy::kOracle);
  }
  CHECK(flag(*batch, "success"));
  for (int cube = 0; cube < 3; ++cube) {
    CHECK(batch->state().prop_pos_of(0, cube)[2] == Approx(0.026).margin(1e-3));
    CHECK(batch->state().status_of(0, cube) == PropStatus::kAsleep);
  }
}

TEST_CASE("Images reveal the colour during the flash only", "[gather][snapshot]") {
  // What is shown of a prop is its pose, its colour and its light.
  const auto red = start(3, 0, 1, 10);
  const auto blue = start(3, 2, 1, 10);
  const auto same = [&] {
    const State& a = red->state();
    const State& b = blue->state();
    const auto equal = [](const auto& x, const auto& y) {
      return std::equal(x.row(0), x.row(0) + x.width(), y.row(0));
    };
    return equal(a.prop_rgba, b.prop_rgba) && equal(a.prop_emission, b.prop_emission) &&
           equal(a.prop_pos, b.prop_pos) && equal(a.qpos, b.qpos);
  };
  int revealed = 0;
  for (int i = 0; i < 150; ++i) {
    const std::vector<float> actions = test::act(*red, Policy::kOracle);
    red->step(actions);
    blue->step(actions);
    CHECK(same() != flag(*red, "flash_active"));
    revealed += flag(*red, "flash_active") ? 1 : 0;
    if (flag(*red, "all_on_disc")) break;
  }
  CHECK(revealed == 10);
}

TEST_CASE("A snapshot in the middle of a grasp goes on bit for bit - gathering",
          "[gather][snapshot]") {
  const auto batch = start(3, 0, 1);
  int steps = 0;
  while (!is_grasping(batch->state(), 0, 0) && ++steps < 60) test::step(*batch, Policy::kOracle);
  REQUIRE(is_grasping(batch->state(), 0, 0));
  const std::vector<std::byte> saved = Snapshotter(*batch).save();
  const auto fresh = start(3, 1, 2);
  Snapshotter(*fresh).restore(saved);
  for (int i = 0; i < 30; ++i) {
    test::step(*batch, Policy::kOracle);
    test::step(*fresh, Policy::kOracle);
    REQUIRE(test::env_bytes(*fresh, 0) == test::env_bytes(*batch, 0));
  }
}

TEST_CASE("Only the first button is the answer", "[gather][answer]") {
  for (const bool strict : {false, true}) {
    const BatchOptions options{
        .auto_reset = AutoReset::kOff,
        .terminate_on_success = false,
        .pins = {{"disc_x", {0.04}}, {"disc_y", {0.14}}, {"flash_color", {1}}},
        .task_options = {{kStrictOption, strict ? 1.0 : 0.0}}};
    const auto batch = make_running("GatherAndRecall3-VLA-v0", options);
    for (int cube = 0; cube < 3; ++cube) put_on_disc(*batch, cube);
    for (const double y : {0.14, 0.28}) {  // green, then blue
      move(*batch, {-0.18, y, 0.12}, 25);
      move(*batch, {-0.18, y, 0.072}, 15);
    }
    CHECK(number(*batch, "first_answer") == 1);
    CHECK(flag(*batch, "first_answer_correct"));
    CHECK(flag(*batch, "success"));
  }
}

TEST_CASE("A single cube leaves time to follow the lamp", "[gather]") {
  for (int color = 0; color < 3; ++color) {
    const auto batch = start(1, color, 1);
    while (batch->state().finished[0] == 0) test::step(*batch, Policy::kSweep);
    CHECK(flag(*batch, "success"));
  }
}

}  // namespace
}  // namespace engram
