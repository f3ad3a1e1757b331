// BatteriesChecker as users see it: scene, stages, teleports, success and observations.
#include <algorithm>
#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/batch/queries.h"
#include "core/batch/snapshot.h"
#include "mjcf/battery.h"
#include "tests/env_helpers.h"

namespace engram {
namespace {

using test::flag, test::make_env, test::make_running, test::row;

const double* const kUpright = mjcf::kBatteryQuat.data();
const std::vector<Pin> kLayout = {{"tray_x", {-0.05}}, {"tray_y", {0.02}}};
const std::vector<TaskOptionValue> kCheckAll = {{"check_all", 1}};

std::unique_ptr<Batch> start(const std::string& id, std::vector<double> working,
                             std::vector<TaskOptionValue> choices = {}) {
  BatchOptions options{.auto_reset = AutoReset::kOff, .pins = kLayout};
  options.pins.push_back({"working", std::move(working)});
  options.task_options = std::move(choices);
  return make_running("BatteriesChecker" + id + "-VLA-v0", options);
}

Eigen::Vector3d pos(const Batch& batch, int battery) {
  return Eigen::Map<const Eigen::Vector3d>(batch.state().prop_pos_of(0, battery));
}
int number(const Batch& batch, const char* name) {
  return *row<std::int32_t>(batch.output(name), 0);
}
void idle(Batch& batch, int steps = 1) {
  for (int i = 0; i < steps; ++i) test::step(batch, Policy::kZero);
}
void put(const Batch& batch, int battery, const Eigen::Vector3d& where,
         PropStatus status = PropStatus::kAsleep) {
  batch.state().place_prop(0, battery, where.data(), kUpright, status);
}
// The first value of a field of the state observation.
const float* observed(const Batch& batch, const std::string& name) {
  int offset = 0;
  for (const Field& field : Queries(batch).state_fields()) {
    if (field.name == name) return batch.outputs().observation.data() + offset;
    offset += field.width;
  }
  FAIL("no field " << name);
  return nullptr;
}

const Eigen::Vector3d kSocketFloor(0.15, 0.02, 0.0405);

TEST_CASE("Batteries stand in their slots, inactive ones are away", "[battery]") {
  const auto batch = start("Hard-3", {1});
  for (int battery = 0; battery < 3; ++battery) {
    CHECK((pos(*batch, battery) - Eigen::Vector3d(-0.05 * battery, -0.084, 0.03)).norm() < 1e-12);
  }
  const float* poses = observed(*batch, "battery_pose");
  for (int battery = 3; battery < 15; ++battery) {
    CHECK(poses[7 * battery + 2] == 1000);
    CHECK(poses[7 * battery + 3] == Approx(0.70710678));
    CHECK(poses[7 * battery + 5] == Approx(0.70710678));
  }
  const auto whole = start("Easy-15", {0, 1, 2, 3, 4, 5, 6, 7, 8});
  for (int battery = 0; battery < 15; ++battery) {
    const Eigen::Vector3d expected(-0.05 * (battery % 3), -0.084 + 0.052 * (battery / 3), 0.03);
    CHECK((pos(*whole, battery) - expected).norm() < 1e-12);
  }
  const float* socket = observed(*batch, "socket_pose");
  const std::vector<double> expected = {0.15, 0.02, 0.015, 0.70710678, 0, 0, 0.70710678};
  for (std::size_t i = 0; i < 7; ++i) CHECK(socket[i] == Approx(expected[i]).margin(1e-6));
  CHECK(observed(*batch, "button_base_pose")[1] == Approx(0.26));
  CHECK(observed(*batch, "button_cap_pose")[2] == Approx(0.044));
}

TEST_CASE("The state observation has the specified widths", "[battery]") {
  const int working[] = {1, 3, 5, 7, 9};
  for (const std::string mode : {"Easy-", "Hard-"}) {
    for (int i = 0; i < 5; ++i) {
      const std::string id = "BatteriesChecker" + mode + std::to_string(3 * (i + 1)) + "-VLA-v0";
      CHECK(make_env(id)->state_dim() == 189 + working[i]);
    }
  }
}

TEST_CASE("Working batteries are distinct active slots, in ascending order", "[battery]") {
  const auto batch = make_running("BatteriesCheckerEasy-6-VLA-v0", {.num_envs = 40});
  std::vector<int> seen(6);
  for (int i = 0; i < 40; ++i) {
    const std::int32_t* slots = row<std::int32_t>(batch->output("oracle_info"), i);
    CHECK(std::is_sorted(slots, slots + 3, std::less_equal<>()));
    for (int k = 0; k < 3; ++k) {
      REQUIRE((slots[k] >= 0 && slots[k] < 6));
      ++seen[static_cast<std::size_t>(slots[k])];
    }
  }
  for (const int times : seen) CHECK(times > 5);
  CHECK_THROWS_AS(start("Easy-6", {1, 1, 2}), Error);
  CHECK_THROWS_AS(start("Easy-6", {1, 2, 6}), Error);
}

TEST_CASE("Hard: an inserted battery is snapped onto the socket's floor", "[battery]") {
  const auto batch = start("Hard-3", {1});
  put(*batch, 1, kSocketFloor + Eigen::Vector3d(0.006, -0.004, 0));
  idle(*batch);
  CHECK(flag(*batch, "new_insert_event"));
  CHECK(flag(*batch, "socket_has_working"));
  CHECK(number(*batch, "socket_battery_idx") == 1);
  CHECK(number(*batch, "action_stage") == 1);
  CHECK(number(*batch, "active_battery_idx") == 1);
  CHECK((pos(*batch, 1) - kSocketFloor).norm() < 1e-9);
  CHECK(observed(*batch, "lamp_on_pose")[2] == 0);
  CHECK(observed(*batch, "lamp_off_pose")[2] == 1000);
  idle(*batch, 30);
  CHECK((pos(*batch, 1) - kSocketFloor).norm() < 1e-3);  // stays, and stays lit
  CHECK(observed(*batch, "lamp_on_pose")[2] == 0);
  CHECK_FALSE(flag(*batch, "new_insert_event"));

  put(*batch, 1, {-0.05, -0.032, 0.03});  // another slot: nothing happens
  idle(*batch, 10);
  CHECK(number(*batch, "action_stage") == 1);
  CHECK(observed(*batch, "lamp_off_pose")[2] == 0);
  put(*batch, 1, {-0.05, -0.084, 0.03});
  idle(*batch);
  CHECK(flag(*batch, "new_return_event"));
  CHECK(number(*batch, "action_stage") == 2);
}

TEST_CASE("A battery 10 mm off the socket's centre is inserted, further off it is not",
          "[battery]") {
  for (const double offset : {0.0099, 0.0101}) {
    const auto batch = start("Hard-3", {1});
    put(*batch, 0, kSocketFloor + Eigen::Vector3d(0, offset, 0));
    idle(*batch);
    CHECK(flag(*batch, "new_insert_event") == (offset < 0.010));
  }
}

TEST_CASE("Easy: an inserted battery returns in the same step and the lamp glows on", "[battery]") {
  const auto batch = start("Easy-3", {2});
  put(*batch, 2, kSocketFloor);
  idle(*batch);
  CHECK(flag(*batch, "new_insert_event"));
  CHECK(flag(*batch, "new_return_event"));
  CHECK_FALSE(flag(*batch, "socket_has_battery"));
  CHECK(number(*batch, "socket_battery_idx") == -1);
  CHECK(number(*batch, "action_stage") == 2);
  CHECK((pos(*batch, 2) - Eigen::Vector3d(-0.10, -0.084, 0.03)).norm() < 1e-12);
  for (int step = 1; step < 10; ++step) {
    CHECK((observed(*batch, "lamp_on_pose")[2] == 0) == (step <= 7));
    idle(*batch);
  }
}

TEST_CASE("Easy: the oracle opens for one step more after a battery has counted", "[battery]") {
  const auto batch = start("Easy-3", {1});
  int inserted = 0;
  for (int step = 0; step < batch->horizon() && inserted == 0; ++step) {
    test::step(*batch, Policy::kOracle);
    inserted = flag(*batch, "new_insert_event");
  }
  REQUIRE(inserted == 1);
  CHECK(test::act(*batch, Policy::kOracle).back() > 0);
  test::step(*batch, Policy::kOracle);
  CHECK(test::act(*batch, Policy::kOracle).back() < 0);
}

TEST_CASE("A returning battery makes way for what stands in its slot", "[battery]") {
  const auto batch = start("Easy-3", {2});
  const Eigen::Vector3d slot(0, -0.084, 0.03);
  put(*batch, 1, slot + Eigen::Vector3d(0.008, 0, 0));
  put(*batch, 0, kSocketFloor);
  idle(*batch);
  REQUIRE(flag(*batch, "new_return_event"));
  CHECK((pos(*batch, 0) - slot).head<2>().norm() <= 0.023);
  CHECK((pos(*batch, 0) - pos(*batch, 1)).norm() >= 0.020);
  idle(*batch, 20);
  CHECK(pos(*batch, 0).z() == Approx(0.03).margin(1e-3));  // nobody was thrown
  CHECK(pos(*batch, 1).z() == Approx(0.03).margin(1e-3));
}

TEST_CASE("What stood on a battery falls when that is sent home", "[battery][sleep]") {
  const auto batch = start("Easy-3", {2});
  put(*batch, 0, kSocketFloor);
  put(*batch, 1, kSocketFloor + Eigen::Vector3d(0.001, 0, 0.06));
  idle(*batch, 25);
  CHECK(pos(*batch, 1).z() < 0.06);
}

TEST_CASE("The tray's neighbours sleep while a battery is handled", "[battery][sleep]") {
  const auto batch = start("Hard-15", {0, 1, 2, 3, 4, 5, 6, 7, 8});
  int most = 0;
  for (int step = 0; step < 60; ++step) {
    test::step(*batch, Policy::kOracle);
    int awake = 0;
    for (int battery = 0; battery < 15; ++battery) {
      awake += batch->state().status_of(0, battery) == PropStatus::kAwake ? 1 : 0;
    }
    most = std::max(most, awake);
  }
  CHECK(most >= 1);
  CHECK(most <= 3);
}

// Plays the oracle until `done`; false if that does not happen in time.
template <class Done>
bool play(Batch& batch, int most, const Done& done) {
  for (int i = 0; i < most; ++i) {
    if (done()) return true;
    test::step(batch, Policy::kOracle);
  }
  return done();
}

// Words of the benchmark's documentation: "every working battery must be discovered through the
// full insert-return-confirm procedure".
TEST_CASE("Success is that every working battery was found", "[battery]") {
  for (const std::string id : {"Easy-3", "Hard-3"}) {
    const auto batch = start(id, {1});
    CHECK(batch->info().options[0].name == "check_all");
    REQUIRE(play(*batch, 150, [&] { return number(*batch, "checked_count") == 1; }));
    CHECK_FALSE(flag(*batch, "success"));  // a dud
    REQUIRE(play(*batch, 150, [&] { return flag(*batch, "new_return_event"); }));
    CHECK_FALSE(flag(*batch, "success"));  // inserted and returned, not confirmed
    put(*batch, 0, {0.0, -0.3, 0.03});  // a dud that is lost has been found to be one all the same
    REQUIRE(play(*batch, 150, [&] { return number(*batch, "checked_count") == 2; }));
    CHECK(number(*batch, "found_working_count") == 1);
    CHECK_FALSE(flag(*batch, "all_checked"));
    CHECK(flag(*batch, "success"));
    CHECK(*row<std::uint8_t>(batch->output("terminated"), 0) == 1);
    CHECK(batch->outputs().reward[0] == 1);
  }
}

TEST_CASE("The number of working batteries decides what success needs", "[battery]") {
  for (const int working : {1, 2, 3}) {
    MakeOptions options{{.auto_reset = AutoReset::kOff, .pins = {{"working", {0}}}},
                        {{"WORKING_BATTERY_COUNT", working}}};
    for (int i = 1; i < working; ++i) options.pins[0].values.push_back(i);
    const auto batch = make_running("BatteriesCheckerEasy-3-VLA-v0", options);
    REQUIRE(play(*batch, 300, [&] { return flag(*batch, "success"); }));
    CHECK(number(*batch, "checked_count") == working);
  }
}

TEST_CASE("Chance is that of the rules of the batch", "[battery]") {
  for (const Rules rules : {Rules::kReference, Rules::kOriginal}) {
    const auto batch = make_env("BatteriesCheckerEasy-3-VLA-v0", {.rules = rules});
    CHECK(batch->info().chance() == Approx((rules == Rules::kOriginal ? 6.0 : 19.0) / 27));
  }
}

TEST_CASE("check_all: success needs every battery checked and none lost", "[battery]") {
  const auto batch = start("Easy-3", {0}, kCheckAll);
  REQUIRE(play(*batch, 200, [&] { return number(*batch, "checked_count") == 2; }));
  CHECK(number(*batch, "found_working_count") == 1);
  CHECK_FALSE(flag(*batch, "success"));  // all that work are found, but not all are checked
  put(*batch, 0, {0.0, -0.084 - 0.075, 0.03});
  REQUIRE(play(*batch, 200, [&] { return number(*batch, "checked_count") == 3; }));
  CHECK(flag(*batch, "all_checked"));
  CHECK_FALSE(flag(*batch, "success"));
  put(*batch, 0, {0.0, -0.084 - 0.065, 0.03});
  idle(*batch);
  CHECK(flag(*batch, "success"));
  CHECK(*row<std::uint8_t>(batch->output("terminated"), 0) == 1);
  CHECK(batch->outputs().reward[0] == 1);
}

TEST_CASE("upstream_rewards pays no bonus for a find", "[battery][reward]") {
  const auto reward_of_confirm = [](double option) {
    const auto batch = start("Easy-3", {0}, {{"upstream_rewards", option}, {"check_all", 1}});
    REQUIRE(play(*batch, 200, [&] { return flag(*batch, "new_confirm_event"); }));
    return batch->outputs().reward[0];
  };
  // 19 against 5, both of 40.
  CHECK(reward_of_confirm(0) - reward_of_confirm(1) == Approx(14.0 / 40).margin(1e-6));
}

TEST_CASE("Easy: socket_battery_idx is -1 when a battery returns, whatever an empty socket has",
          "[battery]") {
  for (const double empty : {-1.0, 0.0}) {
    const auto batch = start("Easy-3", {2}, {{"socket_battery_idx", empty}});
    put(*batch, 2, kSocketFloor);
    idle(*batch);
    REQUIRE(flag(*batch, "new_return_event"));
    CHECK(number(*batch, "socket_battery_idx") == -1);
    idle(*batch);
    CHECK(number(*batch, "socket_battery_idx") == empty);
  }
}

TEST_CASE("socket_battery_idx of an empty socket is the option's value", "[battery]") {
  for (const double empty : {-1.0, 0.0}) {
    const auto batch = start("Hard-3", {1}, {{"socket_battery_idx", empty}});
    CHECK(number(*batch, "socket_battery_idx") == empty);
    idle(*batch);
    CHECK(number(*batch, "socket_battery_idx") == empty);
    CHECK_FALSE(flag(*batch, "socket_has_battery"));
    put(*batch, 1, kSocketFloor);
    idle(*batch);
    CHECK(flag(*batch, "socket_has_battery"));
    CHECK(number(*batch, "socket_battery_idx") == 1);
    put(*batch, 1, {0, -0.3, 0.03});
    idle(*batch);
    CHECK(number(*batch, "socket_battery_idx") == empty);
  }
}

TEST_CASE("Only the lamp reveals which batteries work", "[battery]") {
  // What is shown of a prop is its pose, its colour and its light.
  const auto one = start("Hard-3", {0}, kCheckAll);
  const auto other = start("Hard-3", {1}, kCheckAll);
  const auto same = [&] {
    const State& a = one->state();
    const State& b = other->state();
    const auto equal = [](const auto& x, const auto& y) {
      return std::equal(x.row(0), x.row(0) + x.width(), y.row(0));
    };
    return equal(a.prop_rgba, b.prop_rgba) && equal(a.prop_emission, b.prop_emission) &&
           equal(a.prop_pos, b.prop_pos) && equal(a.qpos, b.qpos);
  };
  const auto lit = [](const Batch& batch) { return observed(batch, "lamp_on_pose")[2] == 0; };
  int revealed = 0;
  for (int i = 0; i < 240; ++i) {
    const std::vector<float> actions = test::act(*one, Policy::kOracle);
    one->step(actions);
    other->step(actions);
    CHECK(same() == (lit(*one) == lit(*other)));
    revealed += lit(*one) == lit(*other) ? 0 : 1;
  }
  CHECK(number(*one, "checked_count") == 2);
  CHECK(revealed >= 14);
}

TEST_CASE("Snapshots in the middle of grasps and insertions go on bit for bit",
          "[battery][snapshot]") {
  for (const std::string id : {"Easy-3", "Hard-3"}) {
    const auto batch = start(id, {0}, kCheckAll);
    int taken = 0;
    const auto check = [&] {
      const std::vector<std::byte> saved = Snapshotter(*batch).save();
      std::vector<test::Bytes> expected;
      for (int i = 0; i < 8; ++i) {
        test::step(*batch, Policy::kOracle);
        expected.push_back(test::env_bytes(*batch, 0));
      }
      const auto fresh = start(id, {1}, kCheckAll);
      Snapshotter(*fresh).restore(saved);
      for (const test::Bytes& bytes : expected) {
        test::step(*fresh, Policy::kOracle);
        CHECK(test::env_bytes(*fresh, 0) == bytes);
      }
      ++taken;
    };
    REQUIRE(play(*batch, 100, [&] { return is_grasping(batch->state(), 0, 0); }));
    check();
    REQUIRE(play(*batch, 100, [&] { return flag(*batch, "new_insert_event"); }));
    check();
    REQUIRE(play(*batch, 150, [&] { return flag(*batch, "new_confirm_event"); }));
    check();
    CHECK(taken == 3);
  }
}

}  // namespace
}  // namespace engram
