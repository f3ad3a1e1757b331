// The place to which the cube comes first after the target is the robot's answer.
#include <catch2/catch.hpp>
#include <vector>

#include "tests/tasks/first_answer.h"

namespace engram {
namespace {

using test::first_answer, test::FirstAnswer;

constexpr double kGoalX = 0.22;
constexpr double kStartX = -0.03;
constexpr double kShift = 0.01;

// Starts in a slot; nothing moves by itself.
class Cube {
 public:
  Cube(int slot, bool strict) {
    const BatchOptions options{.substeps = 0,
                               .pins = {{"slot", {static_cast<double>(slot)}},
                                        {"initial_x", {kStartX}},
                                        {"initial_shift", {kShift}},
                                        {"goal_x", {kGoalX}},
                                        {"goal_y", {0}}},
                               .task_options = {{kStrictOption, strict ? 1.0 : 0.0}}};
    batch_ = test::make_env("TakeItBack-VLA-v0", options);
    batch_->reset();
  }

  // pace: m/s.
  void put(double x, double y, double pace = 0.2) {
    double* pos = batch_->state().prop_pos_of(0, 0);
    pos[0] = x;
    pos[1] = y;
    batch_->state().prop_qvel_of(0, 0)[0] = pace;
    test::step(*batch_, Policy::kZero);
  }
  // Puts the cube into a slot, at one place.
  void put_into(int slot) { put(kStartX, 0.1 * slot + kShift); }

  FirstAnswer answer() const { return first_answer(*batch_); }
  bool succeeds() const { return batch_->outputs().success[0] != 0; }
  bool fails() const { return *test::row<std::uint8_t>(batch_->output("failed"), 0) != 0; }

 private:
  std::unique_ptr<Batch> batch_;
};

TEST_CASE("The slot into which the cube comes after the target is the answer",
          "[take_it_back][answer]") {
  for (const int slot : {-1, 0, 1}) {
    for (const int to : {-1, 0, 1}) {
      Cube cube(slot, true);
      cube.put_into(to);  // the target comes first
      CHECK_FALSE(cube.answer().given);
      cube.put(kGoalX, 0);
      CHECK_FALSE(cube.answer().given);
      cube.put_into(to);
      CHECK(cube.answer() == FirstAnswer{true, to, to == slot});
      CHECK(cube.succeeds() == (to == slot));
      cube.put_into(slot);
      CHECK(cube.answer() == FirstAnswer{true, to, to == slot});
      CHECK(cube.succeeds() == (to == slot));
    }
  }
}

TEST_CASE("A cube that passes by has not come to a place, one that rests there has",
          "[take_it_back][answer]") {
  for (const bool strict : {false, true}) {
    Cube cube(1, strict);
    cube.put(kGoalX, 0);
    cube.put(kStartX + 0.06, 0.1 + kShift);
    CHECK_FALSE(cube.answer().given);
    CHECK(cube.succeeds() == !strict);  // success does not ask where it goes
    cube.put(kStartX + 0.06, 0.1 + kShift, 0);
    CHECK(cube.answer() == FirstAnswer{true, 1, true});
    CHECK(cube.succeeds());
  }
  // On the target it rests without an answer.
  Cube cube(0, false);
  cube.put(kGoalX - 0.07, kShift, 0);
  CHECK_FALSE(cube.answer().given);
}

TEST_CASE("A drag through all slots succeeds, but is a guess", "[take_it_back][answer]") {
  for (const bool strict : {false, true}) {
    Cube cube(1, strict);
    cube.put(kGoalX, 0);
    bool succeeded = false;
    for (int i = -8; i <= 12; ++i) {
      cube.put(0, 0.01 * i);
      succeeded |= cube.succeeds();
    }
    CHECK(cube.answer() == FirstAnswer{true, -1, false});
    CHECK(succeeded == !strict);
    CHECK(cube.fails() == strict);
  }
}

}  // namespace
}  // namespace engram
