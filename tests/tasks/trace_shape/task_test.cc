// TraceShape and TraceShapeSeq as their users see them.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <string>
#include <vector>

#include "core/batch/queries.h"
#include "tasks/common/tcp_servo.h"
#include "tasks/trace_shape/demo.h"
#include "tests/env_helpers.h"

namespace engram {
namespace {

using tasks::Contour;

const tasks::ContourSet kShapes;
using tasks::Vec2, test::make_running, test::row;

constexpr int kRed = 0;
constexpr int kGreen = 1;
constexpr int kBulb = 3;

template <class T>
T info(const Batch& batch, const char* name, int index = 0) {
  return *row<T>(batch.output(name), index);
}

Vec2 place(const Batch& batch, int prop, int index = 0) {
  const double* pos = batch.state().prop_pos_of(index, prop);
  return {pos[0], pos[1]};
}

std::string lamp(const Batch& batch, int index = 0) {
  const float* rgba = batch.state().prop_rgba.row(index) + 4 * kBulb;
  const float glow = batch.state().prop_emission.row(index)[kBulb];
  if (glow == 0) return rgba[0] == rgba[1] ? "white" : "?";
  return rgba[0] == 1 && rgba[1] == 0 ? "red" : rgba[1] == 1 && rgba[0] == 0 ? "green" : "?";
}

BatchOptions pinned(std::vector<Pin> pins) {
  BatchOptions options{.threads = 1, .auto_reset = AutoReset::kOff, .pins = std::move(pins)};
  return options;
}

// Steps without action to that step count.
void wait_until(Batch& batch, int elapsed) {
  const std::vector<float> rest = test::zeros(batch);
  while (batch.state().elapsed[0] < elapsed) batch.step(rest);
}

TEST_CASE("TraceShape keeps to the timeline of the example: P = 5, C = 69", "[trace]") {
  const auto batch = make_running("TraceShapeHard-VLA-v0", pinned({{"shape", {2}},
                                                                   {"radius", {0.1}},
                                                                   {"rotation", {0.3}},
                                                                   {"center_x", {-0.10}},
                                                                   {"center_y", {0.05}},
                                                                   {"pre_demo_steps", {5}}}));
  const Contour contour(kShapes, 2, 0.1, 0.3, {-0.10, 0.05});
  CHECK(Queries(*batch).cue_end(0) == 69);
  CHECK((place(*batch, kGreen) - Vec2(-0.26, 0.05)).norm() < 1e-12);
  for (int elapsed = 0; elapsed < 75; ++elapsed) {
    wait_until(*batch, elapsed);
    INFO(elapsed);
    CHECK(lamp(*batch) == (elapsed < 5 ? "white" : elapsed < 69 ? "red" : "green"));
    CHECK(info<std::uint8_t>(*batch, "pre_demo_mask") == (elapsed < 5 ? 1 : 0));
    CHECK(info<std::uint8_t>(*batch, "demo_mask") == (elapsed >= 5 && elapsed < 69 ? 1 : 0));
    CHECK(info<std::uint8_t>(*batch, "action_mask") == (elapsed >= 69 ? 1 : 0));
    const int waypoint = std::clamp(elapsed - 5, 0, 63);
    CHECK((place(*batch, kRed) - contour.waypoint(waypoint)).norm() < 1e-12);
    const double height = batch->state().prop_pos_of(0, kRed)[2];
    CHECK(height == Approx(elapsed < 69 ? 0.02 : 1000.02));
    CHECK((batch->state().status_of(0, kRed) == PropStatus::kHidden) == (elapsed >= 69));
    CHECK(info<std::int32_t>(*batch, "oracle_info") == 2);
    CHECK(info<std::uint8_t>(*batch, "success") == 0);
  }
  CHECK(batch->state_dim() == 42);
}

// As in the original.
const std::vector<TaskOptionValue> kPushing = {{"red_pushes_green", 1}};

TEST_CASE("The red cube passes through a green one that sleeps", "[trace][pushing][original]") {
  for (const char* id : {"TraceShapeMedium-VLA-v0", "TraceShapeSeqMedium-VLA-v0"}) {
    INFO(id);
    const BatchOptions options{.num_envs = 64, .task_options = kPushing};
    const auto batch = make_running(id, options);
    std::vector<Vec2> before;
    for (int i = 0; i < options.num_envs; ++i) before.push_back(place(*batch, kGreen, i));
    int met = 0;
    for (int step = 0; step < 70; ++step) {
      test::step(*batch, Policy::kZero);
      for (int i = 0; i < options.num_envs; ++i) {
        const Vec2 offset = place(*batch, kGreen, i) - place(*batch, kRed, i);
        met += offset.lpNorm<Eigen::Infinity>() < 0.03 ? 1 : 0;
        REQUIRE(place(*batch, kGreen, i) == before[static_cast<std::size_t>(i)]);
      }
    }
    CHECK(met > 20);
  }
}

TEST_CASE("The red cube pushes a green one that is awake out of its way", "[trace][pushing]") {
  // A circle that passes through the green cube's place.
  BatchOptions options = pinned({{"shape", {0}}, {"radius", {0.13}}, {"rotation", {0}}});
  options.sleep = false;
  options.task_options = kPushing;
  const auto batch = make_running("TraceShapeHard-VLA-v0", options);
  const Vec2 before = place(*batch, kGreen);
  const std::vector<float> rest = test::zeros(*batch);
  while (batch->state().elapsed[0] < 90) {
    batch->step(rest);
    REQUIRE(std::abs(batch->state().prop_pos_of(0, kGreen)[2] - 0.02) < 0.006);
  }
  const double pushed = (place(*batch, kGreen) - before).norm();
  CHECK(pushed > 0.005);
  CHECK(pushed < 0.10);
}

TEST_CASE("Cubes that push never overlap at reset", "[trace]") {
  using tasks::clear_of_red;
  CHECK(clear_of_red({0, 0}, {0.041, 0}) == Vec2(0, 0));
  CHECK(clear_of_red({0, 0}, {0.039, 0.041}) == Vec2(0, 0));
  CHECK((clear_of_red({0, 0}, {0.039, 0.01}) - Vec2(0, 0.01 - 0.0405)).norm() < 1e-15);
  CHECK((clear_of_red({0, 0}, {-0.01, -0.03}) - Vec2(0, -0.03 + 0.0405)).norm() < 1e-15);
  CHECK(clear_of_red({0, 0}, {0.02, 0}) == Vec2(0, 0.0405));  // level: towards +y

  const BatchOptions options{.num_envs = 2000, .task_options = kPushing};
  const auto batch = make_running("TraceShapeHard-VLA-v0", options);
  int shifted = 0;
  for (int i = 0; i < options.num_envs; ++i) {
    const Vec2 offset = place(*batch, kGreen, i) - place(*batch, kRed, i);
    REQUIRE((std::abs(offset.x()) >= 0.04 || std::abs(offset.y()) >= 0.04));
    const double* center = row<double>(test::memory_of(*batch).find("center"), i);
    shifted += place(*batch, kGreen, i) == Vec2(center[0] - 0.16, center[1]) ? 0 : 1;
  }
  CHECK(shifted > 0.015 * options.num_envs);
  CHECK(shifted < 0.055 * options.num_envs);
}

TEST_CASE("TraceShape ends with the contour closed", "[trace]") {
  const BatchOptions options{.num_envs = 4, .auto_reset = AutoReset::kOff};
  const auto batch = make_running("TraceShapeHard-VLA-v0", options);
  for (int i = 0; i < 200; ++i) test::step(*batch, Policy::kOracle);
  for (int i = 0; i < options.num_envs; ++i) {
    CHECK(batch->outputs().terminated[static_cast<std::size_t>(i)] == 1);
    CHECK(info<std::uint8_t>(*batch, "success", i) == 1);
    CHECK(info<std::uint8_t>(*batch, "all_visited", i) == 1);
    CHECK(info<float>(*batch, "visit_fraction", i) == 1);
    CHECK(info<float>(*batch, "start_checkpoint_dist", i) < 0.035F);
    for (int k = 0; k < 12; ++k)
      CHECK(row<std::uint8_t>(batch->output("checkpoint_visited"), i)[k]);
  }
}

TEST_CASE("TraceShapeSeq keeps to the timeline of the example: L = 2, P = 4, C = 132", "[trace]") {
  const auto batch = make_running(
      "TraceShapeSeqHard-VLA-v0",
      pinned({{"sequence_length", {2}}, {"shapes", {1, 2, 0, 0, 0}}, {"pre_demo_steps", {4}}}));
  const double* radii = row<double>(test::memory_of(*batch).find("radii"), 0);
  const double* turns = row<double>(test::memory_of(*batch).find("rotations"), 0);
  const double* center = row<double>(test::memory_of(*batch).find("center"), 0);
  const auto contour = [&](int element) {
    return Contour(kShapes, element == 0 ? 1 : 2, radii[element], turns[element],
                   {center[0], center[1]});
  };
  CHECK(Queries(*batch).cue_end(0) == 132);
  CHECK(batch->state_dim() == 52);
  const std::int32_t expected[] = {1, 2, -1, -1, -1};
  CHECK(std::equal(expected, expected + 5, row<std::int32_t>(batch->output("oracle_info"), 0)));
  CHECK(std::equal(expected, expected + 5, row<std::int32_t>(batch->output("task_cue"), 0)));
  const auto red_is_at = [&](int elapsed, int element, int waypoint) {
    wait_until(*batch, elapsed);
    INFO(elapsed);
    CHECK((place(*batch, kRed) - contour(element).waypoint(waypoint)).norm() < 1e-12);
  };
  red_is_at(4, 0, 0);
  red_is_at(5, 0, 1);
  red_is_at(67, 0, 63);
  red_is_at(68, 1, 0);
  red_is_at(131, 1, 63);
  CHECK(lamp(*batch) == "red");
  wait_until(*batch, 132);
  CHECK(lamp(*batch) == "green");
  CHECK(batch->state().status_of(0, kRed) == PropStatus::kHidden);
}

// Moves the tool to `height` over the button, 50 mm nearer to the robot than its centre.
void press_button(Batch& batch, double height) {
  const double* center = row<double>(test::memory_of(batch).find("trace_shape_seq_button_xy"), 0);
  const Vec2 base(tasks::kRobotBaseX, 0);
  const Vec2 outward = Vec2(center[0], center[1]) - base;
  const Vec2 at = base + outward * (1 - 0.05 / outward.norm());
  std::vector<float> action = test::zeros(batch);
  const Eigen::Vector3d goal(at.x(), at.y(), height);
  tasks::servo_tcp(batch.state(), 0, goal, tasks::tilt_outwards(tasks::kToolDown, goal), 1,
                   action.data());
  batch.step(action);
}

TEST_CASE("A press before all contours are closed ends TraceShapeSeq in failure", "[trace]") {
  BatchOptions options = pinned({{"sequence_length", {2}}, {"center_x", {-0.15}}});
  options.reward_mode = RewardMode::kDense;
  const auto batch = make_running("TraceShapeSeqEasy-VLA-v0", options);
  // During the demonstration the button does not react.
  while (batch->state().elapsed[0] < 60) press_button(*batch, 0.07);
  CHECK(batch->state().tcp_pos.row(0)[2] < 0.08);
  CHECK(info<float>(*batch, "button_press_depth") == 0);
  CHECK(batch->outputs().terminated[0] == 0);
  while (batch->state().elapsed[0] < Queries(*batch).cue_end(0)) press_button(*batch, 0.20);
  for (int i = 0; i < 40 && batch->outputs().terminated[0] == 0; ++i) press_button(*batch, 0.07);
  CHECK(batch->outputs().terminated[0] == 1);
  CHECK(info<std::uint8_t>(*batch, "submitted") == 1);
  CHECK(info<std::uint8_t>(*batch, "failed_submit") == 1);
  CHECK(info<std::uint8_t>(*batch, "success") == 0);
  CHECK(info<std::uint8_t>(*batch, "button_pressed") == 1);
  CHECK(batch->outputs().reward[0] == -2);
}

TEST_CASE("Contours count one after the other, and the submission ends the episode", "[trace]") {
  BatchOptions options = pinned({{"sequence_length", {3}}});
  options.reward_mode = RewardMode::kDense;
  const auto batch = make_running("TraceShapeSeqHard-VLA-v0", options);
  int active = 0;
  float progress = 0;
  while (batch->state().finished[0] == 0) {
    test::step(*batch, Policy::kOracle);
    const std::int32_t now = info<std::int32_t>(*batch, "active_shape_idx");
    REQUIRE((now == active || now == active + 1));
    if (now == active + 1) CHECK(info<float>(*batch, "active_visit_fraction") == 0);
    active = now;
    REQUIRE(info<float>(*batch, "sequence_progress") >= progress);
    progress = info<float>(*batch, "sequence_progress");
    CHECK(info<std::uint8_t>(*batch, "button_pressable") == (progress == 1 ? 1 : 0));
  }
  CHECK(active == 2);
  CHECK(batch->outputs().terminated[0] == 1);
  CHECK(info<std::uint8_t>(*batch, "successful_submit_event") == 1);
  CHECK(info<std::uint8_t>(*batch, "success") == 1);
  CHECK(batch->outputs().reward[0] == 40);
}

}  // namespace
}  // namespace engram
