// The angle at which the peg first rests is the robot's answer; a clock helps to find it.
#include <catch2/catch.hpp>
#include <cmath>
#include <string>
#include <vector>

#include "tests/tasks/first_answer.h"

namespace engram {
namespace {

using test::first_answer, test::FirstAnswer, test::make_env, test::make_running, test::row;

constexpr const char* kLenient = "RotateLenientPos-VLA-v0";
constexpr const char* kStrict = "RotateStrictPos-VLA-v0";

// A peg that lies along x; nothing moves by itself.
class Peg {
 public:
  Peg(const char* id, double target, bool strict) {
    batch_ = make_env(id, {.substeps = 0,
                           .pins = {{"initial_yaw", {0.0}}, {"target_angle", {target}}},
                           .task_options = {{kStrictOption, strict ? 1.0 : 0.0}}});
    batch_->reset();
  }

  // Is at this angle after a step; robot_pace: rad/s, of one of the robot's joints.
  void pass(double angle, double robot_pace = 0) {
    double* quat = batch_->state().prop_quat_of(0, 0);
    quat[0] = std::cos(angle / 2);
    quat[3] = std::sin(angle / 2);
    batch_->state().qvel.row(0)[6] = robot_pace;
    test::step(*batch_, Policy::kZero);
  }
  // Stays there for a step.
  void turn_to(double angle, double robot_pace = 0) {
    pass(angle, robot_pace);
    pass(angle, robot_pace);
  }
  // What a hand that holds the peg still leaves it, rad/s.
  void set_velocity(double spin) { batch_->state().prop_qvel_of(0, 0)[5] = spin; }

  FirstAnswer answer() const { return first_answer(*batch_); }
  bool succeeds() const { return batch_->outputs().success[0] != 0; }

 private:
  std::unique_ptr<Batch> batch_;
};

TEST_CASE("The angle at which the turned peg first rests is the answer", "[rotate][answer]") {
  for (const char* id : {kLenient, kStrict}) {
    INFO(id);
    Peg peg(id, 0.8, false);
    peg.turn_to(0.04);  // as good as unturned
    CHECK_FALSE(peg.answer().given);
    peg.pass(0.5);
    CHECK_FALSE(peg.answer().given);
    peg.turn_to(0.6, 0.5);
    CHECK_FALSE(peg.answer().given);
    peg.set_velocity(2.2);
    peg.turn_to(0.75);
    CHECK(peg.answer() == FirstAnswer{true, 43, true});
    CHECK(peg.succeeds());
    peg.turn_to(0.5);
    CHECK(peg.answer() == FirstAnswer{true, 43, true});
  }
  Peg back(kLenient, 0.8, false);
  back.turn_to(-0.3);
  CHECK(back.answer() == FirstAnswer{true, -17, false});
}

TEST_CASE("A peg that turns past its target has not come to rest there", "[rotate][answer]") {
  for (const bool strict : {false, true}) {
    Peg peg(kLenient, 0.8, strict);
    peg.pass(0.8);
    CHECK(peg.succeeds() == !strict);
    CHECK_FALSE(peg.answer().given);
    peg.turn_to(1.2);
    CHECK(peg.answer() == FirstAnswer{true, 69, false});
    peg.turn_to(0.8);
    CHECK(peg.succeeds() == !strict);
  }
}

// At full speed for a time that follows from the target: no memory of the peg is needed.
TEST_CASE("A clock replaces the memory of how the peg lay", "[rotate][answer]") {
  for (const char* id : {"RotateLenientPosNeg-VLA-v0", "RotateStrictPos-VLA-v0"}) {
    INFO(id);
    const BatchOptions options{
        .num_envs = 100, .auto_reset = AutoReset::kOff, .task_options = {{kStrictOption, 1}}};
    const auto batch = make_running(id, options);
    for (int t = 0; t < batch->info().horizon; ++t) test::step(*batch, Policy::kSweep);
    int right = 0;
    for (int i = 0; i < options.num_envs; ++i) {
      right += *row<std::uint8_t>(batch->output("first_answer_correct"), i);
    }
    CHECK(right >= 85);
  }
}

}  // namespace
}  // namespace engram
