// Shapes that a trail commits to; only the demonstration reveals the shape.
#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "core/batch/queries.h"
#include "tasks/trace_shape/demo.h"
#include "tests/tasks/first_answer.h"
#include "tests/tasks/pose_tool.h"

namespace engram {
namespace {

using tasks::Contour, tasks::SHAPE_CIRCLE, tasks::SHAPE_SQUARE, tasks::SHAPE_TRIANGLE, tasks::Vec2,
    test::first_answer, test::FirstAnswer, test::make_running, test::row;

constexpr const char* kMedium = "TraceShapeMedium-VLA-v0";
constexpr const char* kHard = "TraceShapeHard-VLA-v0";
constexpr const char* kSeq = "TraceShapeSeqHard-VLA-v0";
constexpr int kGreen = 1;
const Vec2 kCenter(-0.12, 0.02);
const tasks::ContourSet kShapes;

// Nothing moves by itself; the cube is put where a test wants it.
BatchOptions still(std::vector<Pin> pins, bool strict) {
  BatchOptions options{.auto_reset = AutoReset::kOff,
                       .terminate_on_success = false,
                       .substeps = 0,
                       .pins = std::move(pins)};
  options.pins.push_back({"center_x", {kCenter.x()}});
  options.pins.push_back({"center_y", {kCenter.y()}});
  options.task_options = {{kStrictOption, strict ? 1.0 : 0.0}};
  return options;
}

std::unique_ptr<Batch> show(int shape, double radius, bool strict = false) {
  return make_running(
      kHard,
      still({{"shape", {static_cast<double>(shape)}}, {"radius", {radius}}, {"rotation", {0.3}}},
            strict));
}

// Shows shapes of radius 0.1, unturned.
std::unique_ptr<Batch> show_sequence(std::array<double, 5> shapes, int length) {
  return make_running(kSeq, still({{"shapes", {shapes.begin(), shapes.end()}},
                                   {"radii", std::vector<double>(5, 0.1)},
                                   {"rotations", std::vector<double>(5, 0.0)},
                                   {"sequence_length", {static_cast<double>(length)}}},
                                  false));
}

void wait(Batch& batch) {
  while (batch.state().elapsed[0] < Queries(batch).cue_end(0)) test::step(batch, Policy::kZero);
}

void put_cube(Batch& batch, const Vec2& at) {
  double* pos = batch.state().prop_pos_of(0, kGreen);
  pos[0] = at.x();
  pos[1] = at.y();
  test::step(batch, Policy::kZero);
}

// Once around, until success if that comes first.
void trace(Batch& batch, int shape, double radius, double rotation) {
  const Contour contour(kShapes, shape, radius, rotation, kCenter);
  for (int i = 0; i <= kShapes.waypoints(); ++i) {
    put_cube(batch, contour.waypoint(i % kShapes.waypoints()));
    if (batch.outputs().success[0] != 0) return;
  }
}

// Presses the button of a sequence.
void submit(Batch& batch) {
  const double* button = row<double>(test::memory_of(batch).find("trace_shape_seq_button_xy"), 0);
  test::step_at(batch, {button[0], button[1], 0.07});
}

TEST_CASE("The place of the green cube does not reveal what was traced", "[trace][answer]") {
  for (const char* id : {kMedium, kHard, kSeq}) {
    INFO(id);
    const BatchOptions options{.num_envs = 300, .auto_reset = AutoReset::kOff};
    const auto batch = make_running(id, options);
    for (int t = 0; t < 330; ++t) {
      test::step(*batch, Policy::kZero);
      for (int i = 0; i < options.num_envs; ++i) {
        const double* center = row<double>(test::memory_of(*batch).find("center"), i);
        const double* pos = batch->state().prop_pos_of(i, kGreen);
        const double* quat = batch->state().prop_quat_of(i, kGreen);
        const bool as_placed = pos[0] == center[0] - 0.16 && pos[1] == center[1] &&
                               pos[2] == 0.02 && quat[0] == 1 &&
                               batch->state().status_of(i, kGreen) == PropStatus::kAsleep;
        if (!as_placed) FAIL("environment " << i << ", step " << t);
      }
    }
  }
}

TEST_CASE("A trail commits to the shape that it comes nearest to", "[trace][answer]") {
  for (const int shape : {SHAPE_CIRCLE, SHAPE_SQUARE, SHAPE_TRIANGLE}) {
    for (const double radius : {0.08, 0.13}) {
      INFO(shape << ", " << radius);
      const auto batch = show(shape, radius);
      wait(*batch);
      CHECK_FALSE(first_answer(*batch).given);
      trace(*batch, shape, radius, 0.3);
      CHECK(batch->outputs().success[0] == 1);
      CHECK(first_answer(*batch) == FirstAnswer{true, shape, true});
    }
  }
}

TEST_CASE("What passes for a shape is not that shape", "[trace][answer]") {
  // A circle that is near enough to every checkpoint of the square.
  for (const bool strict : {false, true}) {
    const auto batch = show(SHAPE_SQUARE, 0.08, strict);
    wait(*batch);
    trace(*batch, SHAPE_CIRCLE, 0.08, 0.3);
    trace(*batch, SHAPE_CIRCLE, 0.08, 0.3);
    CHECK(first_answer(*batch) == FirstAnswer{true, SHAPE_CIRCLE, false});
    CHECK((batch->outputs().success[0] != 0) == !strict);
    // The first answer stays.
    trace(*batch, SHAPE_SQUARE, 0.08, 0.3);
    CHECK(first_answer(*batch) == FirstAnswer{true, SHAPE_CIRCLE, false});
    CHECK((batch->outputs().success[0] != 0) == !strict);
  }
}

TEST_CASE("Trails count from the action phase on, once they are closed", "[trace][answer]") {
  const auto batch = show(SHAPE_TRIANGLE, 0.1);
  const Contour contour(kShapes, SHAPE_TRIANGLE, 0.1, 0.3, kCenter);
  while (batch->state().elapsed[0] < Queries(*batch).cue_end(0) - 1) {
    put_cube(*batch, contour.waypoint(batch->state().elapsed[0] % 64));
  }
  put_cube(*batch, kCenter + Vec2(0.3, 0.3));
  for (int i = 0; i < 50; ++i) put_cube(*batch, contour.waypoint(i));
  CHECK_FALSE(first_answer(*batch).given);
}

TEST_CASE("A sequence is answered by its submission", "[trace][answer]") {
  const auto batch = show_sequence({1, 2, 0, 0, 0}, 2);
  wait(*batch);
  trace(*batch, SHAPE_SQUARE, 0.1, 0);
  trace(*batch, SHAPE_TRIANGLE, 0.1, 0);
  CHECK_FALSE(first_answer(*batch).given);
  submit(*batch);
  CHECK(batch->outputs().success[0] == 1);
  CHECK(first_answer(*batch) == FirstAnswer{true, 23, true});
}

TEST_CASE("A sequence is wrong from its first wrong contour on", "[trace][answer]") {
  const auto another = show_sequence({1, 2, 0, 0, 0}, 2);
  wait(*another);
  trace(*another, SHAPE_SQUARE, 0.1, 0);
  trace(*another, SHAPE_CIRCLE, 0.1, 0);
  CHECK(first_answer(*another) == FirstAnswer{true, 21, false});

  const auto one_more = show_sequence({1, 2, 0, 0, 0}, 2);
  wait(*one_more);
  trace(*one_more, SHAPE_SQUARE, 0.1, 0);
  trace(*one_more, SHAPE_TRIANGLE, 0.1, 0);
  trace(*one_more, SHAPE_TRIANGLE, 0.1, 0);
  CHECK(first_answer(*one_more) == FirstAnswer{true, 233, false});

  const auto too_early = show_sequence({1, 2, 0, 0, 0}, 2);
  wait(*too_early);
  trace(*too_early, SHAPE_SQUARE, 0.1, 0);
  submit(*too_early);
  CHECK(first_answer(*too_early) == FirstAnswer{true, 2, false});
}

}  // namespace
}  // namespace engram
