// The object at which the robot first rests is its answer.
#include <catch2/catch.hpp>

#include "tests/tasks/first_answer.h"
#include "tests/tasks/pose_tool.h"
#include "tests/tasks/remember/recall_env.h"

namespace engram {
namespace {

using test::first_answer, test::FirstAnswer, test::make_running, test::memory_int, test::row,
    test::step_at, test::stored_pos;

constexpr int kTarget = 4;
const Eigen::Vector3d kAbove(0, 0, 0.03);  // m

// A posed environment whose objects have appeared.
std::unique_ptr<Batch> make_ready(bool strict) {
  auto batch =
      make_running("RememberColor9-VLA-v0",
                   {.substeps = 0,
                    .pins = {{"target", {kTarget}}, {"cue_steps", {1}}, {"empty_steps", {1}}},
                    .task_options = {{kStrictOption, strict ? 1.0 : 0.0}}});
  test::step(*batch, Policy::kZero);
  return batch;
}

bool succeeds(const Batch& batch) { return batch.outputs().success[0] != 0; }

TEST_CASE("The first object touched is the answer, later ones are not", "[remember][answer]") {
  const auto batch = make_ready(false);
  CHECK(first_answer(*batch) == FirstAnswer{});
  step_at(*batch, {0.1, 0, 0.3});
  CHECK(first_answer(*batch) == FirstAnswer{});
  step_at(*batch, stored_pos(*batch, 2) + kAbove);
  CHECK(first_answer(*batch) == FirstAnswer{true, 2, false});
  step_at(*batch, stored_pos(*batch, kTarget) + kAbove);
  CHECK(first_answer(*batch) == FirstAnswer{true, 2, false});
  CHECK(succeeds(*batch));
}

TEST_CASE("A right first answer stays right", "[remember][answer]") {
  const auto batch = make_ready(true);
  step_at(*batch, stored_pos(*batch, kTarget) + kAbove);
  CHECK(first_answer(*batch) == FirstAnswer{true, kTarget, true});
  CHECK(succeeds(*batch));
  step_at(*batch, stored_pos(*batch, 2) + kAbove);
  CHECK(first_answer(*batch) == FirstAnswer{true, kTarget, true});
  step_at(*batch, stored_pos(*batch, kTarget) + kAbove);
  CHECK(succeeds(*batch));
}

TEST_CASE("A wrong first answer leaves a strict episode without success", "[remember][answer]") {
  const auto batch = make_ready(true);
  step_at(*batch, stored_pos(*batch, 2) + kAbove);
  CHECK(*row<std::uint8_t>(batch->output("failed"), 0) == 1);
  step_at(*batch, stored_pos(*batch, kTarget) + kAbove);
  CHECK_FALSE(succeeds(*batch));
  CHECK(batch->outputs().reward[0] < 1);
}

TEST_CASE("A stop between two objects answers with the nearer one", "[remember][answer]") {
  const auto batch = make_ready(false);
  // The two that are nearest to one another, and a point a little nearer to the first of them.
  const auto away = [&](int a, int b) {
    return (stored_pos(*batch, a) - stored_pos(*batch, b)).norm();
  };
  int one = 0;
  int other = 1;
  for (int a = 0; a < 9; ++a) {
    for (int b = 0; b < 9; ++b) {
      if (a == b || away(a, b) >= away(one, other)) continue;
      one = a;
      other = b;
    }
  }
  CAPTURE(one, other, away(one, other));
  step_at(*batch, 0.52 * stored_pos(*batch, one) + 0.48 * stored_pos(*batch, other));
  CHECK(first_answer(*batch) == FirstAnswer{true, one, one == kTarget});
}

TEST_CASE("Passing by is no answer, nor is anything before the objects appear",
          "[remember][answer]") {
  const auto batch =
      make_running("RememberColor9-Long-VLA-v0",
                   {.substeps = 0,
                    .pins = {{"target", {kTarget}}, {"cue_steps", {100}}, {"empty_steps", {50}}}});
  step_at(*batch, stored_pos(*batch, kTarget) + kAbove);
  CHECK(first_answer(*batch) == FirstAnswer{});
  while (batch->state().elapsed[0] < test::appearance_of(*batch)) step_at(*batch, {0.1, 0, 0.3});
  test::pose_tool(*batch, stored_pos(*batch, 2) + kAbove);
  batch->state().qvel.row(0)[0] = 0.3;  // rad/s
  test::step(*batch, Policy::kZero);
  CHECK_FALSE(first_answer(*batch).given);
}

}  // namespace
}  // namespace engram
