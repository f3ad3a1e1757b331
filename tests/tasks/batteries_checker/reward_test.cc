// The stage machine and the reward of BatteriesChecker in worked examples.
#include "tasks/batteries_checker/reward.h"

#include <catch2/catch.hpp>
#include <cmath>

namespace engram::tasks {
namespace {

// Battery 1 works, battery 0 does not.
constexpr BatterySet kWorkingSet = 0b10;

CheckInputs in_socket(int battery, bool pressed = false) {
  return {.in_socket = battery_bit(battery), .working = kWorkingSet, .pressed = pressed};
}
CheckInputs at_home(BatterySet home, bool pressed = false) {
  return {.home = home, .working = kWorkingSet, .pressed = pressed};
}

TEST_CASE("Sets of batteries", "[battery]") {
  CHECK(lowest(0) == -1);
  CHECK(lowest(0b1100) == 2);
  CHECK(count(0b1101) == 3);
  CHECK(contains(0b100, 2));
  CHECK_FALSE(contains(0b100, 1));
}

TEST_CASE("A round goes from insertion over return to confirmation", "[battery]") {
  CheckState state;
  CheckEvents events = check_step(at_home(0b11), state);
  CHECK_FALSE((events.insert || events.returned || events.confirm || events.lamp));
  events = check_step(at_home(0b11, true), state);  // nothing to confirm yet
  CHECK_FALSE(events.confirm);
  CHECK(state.stage == STAGE_INSERT);

  events = check_step(in_socket(1), state);
  CHECK(events.insert);
  CHECK(events.socket_battery == 1);
  CHECK(events.socket_works);
  CHECK(state.stage == STAGE_RETURN);
  CHECK(state.active == 1);

  events = check_step(at_home(0b01, true), state);  // in the hand, too early a press
  CHECK_FALSE((events.returned || events.confirm));
  events = check_step(at_home(0b01), state);  // another battery's slot does not count
  CHECK(state.stage == STAGE_RETURN);
  events = check_step(at_home(0b11), state);
  CHECK(events.returned);
  CHECK(state.stage == STAGE_CONFIRM);

  events = check_step(in_socket(0), state);  // only the active battery is judged
  CHECK_FALSE(events.insert);
  CHECK(state.active == 1);
  events = check_step(at_home(0b11, true), state);
  CHECK(events.confirm);
  CHECK(events.newly_found);
  CHECK(state.checked == 0b10);
  CHECK(state.found == 0b10);
  CHECK(state.stage == STAGE_INSERT);
  CHECK(state.active == -1);
}

TEST_CASE("A return and a press in one step confirm at once", "[battery]") {
  CheckState state{.stage = STAGE_RETURN, .active = 0};
  const CheckEvents events = check_step(at_home(0b01, true), state);
  CHECK(events.returned);
  CHECK(events.confirm);
  CHECK_FALSE(events.newly_found);
  CHECK(state.checked == 0b01);
  CHECK(state.found == 0);
}

TEST_CASE("Checking a battery again changes no count", "[battery]") {
  CheckState state{.stage = STAGE_CONFIRM, .active = 1, .checked = 0b10, .found = 0b10};
  const CheckEvents events = check_step(at_home(0b11, true), state);
  CHECK(events.confirm);
  CHECK_FALSE(events.newly_found);
  CHECK(state.checked == 0b10);
}

TEST_CASE("The lamp glows for seven steps", "[battery]") {
  // Inserted at 200, in the hand again from `taken` on (hard), or sent home at once (easy).
  const auto lit_until = [](int taken, bool easy) {
    CheckState state;
    int last = 0;
    for (int step = 200; step < 240; ++step) {
      CheckEvents events = check_step(step < taken ? in_socket(1) : at_home(0b01), state);
      if (events.lamp) last = step;
      CHECK(events.lamp == (step <= last));
      if (easy && return_by_itself(state, events)) taken = 0;
    }
    return last;
  };
  CHECK(lit_until(1000, true) == 206);
  CHECK(lit_until(215, false) == 214);
  CHECK(lit_until(203, false) == 206);
}

TEST_CASE("A dud leaves the lamp dark", "[battery]") {
  CheckState state;
  CHECK_FALSE(check_step(in_socket(0), state).lamp);
  CHECK(state.afterglow == 0);
}

TEST_CASE("Easy: an insertion ends in the confirmation stage and eats the press", "[battery]") {
  CheckState state;
  CheckEvents events = check_step(in_socket(1, true), state);
  CHECK_FALSE(events.confirm);
  CHECK_FALSE(events.taken_out);
  CHECK(return_by_itself(state, events));
  CHECK(events.insert);
  CHECK(events.returned);
  CHECK(events.taken_out);
  CHECK(events.socket_battery == -1);
  CHECK_FALSE(events.socket_works);
  CHECK(state.stage == STAGE_CONFIRM);
  CHECK_FALSE(return_by_itself(state, events));
}

constexpr SmoothnessParams kWeights = {
    .ACTION_L2_COEF = 0.01, .ACTION_DELTA_L2_COEF = 0.02, .QVEL_L2_COEF = 0.01};

// The first action of an episode is (0.5, -0.2, -1, 0, 0, 0.5, 1) and |qdot| = 0.4.
const ActionCost kActionCost{
    .action_norm = 1.593738, .action_delta_norm = 1.593738, .arm_speed = 0.4};

TEST_CASE("The battery reward's examples", "[battery][reward]") {
  CHECK(smoothness(kActionCost, kWeights).penalty == Approx(0.036606).margin(1e-6));
  BatteryReward insert{.smoothness = kWeights};
  insert.unchecked_distance = 0.08;
  insert.home_distance = 0.3;
  insert.button_distance = insert.socket_distance = 0.3;
  insert.action_cost = kActionCost;
  CHECK(insert.compute() == Approx(0.791985).margin(1e-6));

  BatteryReward confirm = insert;
  confirm.stage = STAGE_CONFIRM;
  confirm.button_distance = 0.084 - 0.063;
  confirm.socket_distance = 0.317043;
  confirm.press_depth = 0.004 / 0.014;
  CHECK(confirm.compute() == Approx(2.178093).margin(1e-6));
  confirm.upstream = true;
  CHECK(confirm.compute() == Approx(0.700095).margin(1e-6));
}

TEST_CASE("What a valid confirmation is worth", "[battery][reward]") {
  BatteryReward in{.smoothness = kWeights};
  in.stage = STAGE_INSERT;
  in.pressed = true;
  in.events.confirm = true;
  const auto bonus = [&](bool works, bool upstream) {
    in.events.newly_found = works;
    in.upstream = upstream;
    return in.compute();
  };
  CHECK(bonus(true, false) == Approx(19));
  CHECK(bonus(false, false) == Approx(7));
  CHECK(bonus(true, true) == Approx(5));
  CHECK(bonus(false, true) == Approx(5));
  in.events.confirm = false;  // a press for nothing
  CHECK(bonus(false, false) == Approx(-2));
  in.stage = STAGE_CONFIRM;
  in.button_distance = in.socket_distance = 100;
  CHECK(bonus(false, false) == Approx(0));
  in.success = true;
  CHECK(bonus(false, false) == 40);
}

}  // namespace
}  // namespace engram::tasks
