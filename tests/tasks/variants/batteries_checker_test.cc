// BatteriesChecker with other constants: what follows from each, and sets that contradict
// themselves.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "mjcf/battery.h"
#include "tests/env_helpers.h"
#include "tests/tasks/pose_tool.h"
#include "tests/tasks/variants/constant_text.h"

namespace engram {
namespace {

using Catch::Contains, Eigen::Vector3d, test::flag, test::row;

constexpr const char* kEasy = "BatteriesCheckerEasy-3-VLA-v0";
constexpr const char* kHard = "BatteriesCheckerHard-3-VLA-v0";
const Vector3d kSocket(0.15, 0.02, 0.03);  // what distances are measured from
const Vector3d kSlot(0, -0.084, 0.03);     // of battery 0
const Vector3d kButton(-0.05, 0.26, 0);
const Vector3d kFarAway(-0.1, 0, 0.4);

// Without physics; battery 0 works.
std::unique_ptr<Batch> make(const char* id, const ConstantTable& constants = {},
                            bool check_all = false) {
  const MakeOptions options{{.reward_mode = RewardMode::kDense,
                             .auto_reset = AutoReset::kOff,
                             .substeps = 0,
                             .pins = {{"tray_x", {-0.05}}, {"tray_y", {0.02}}, {"working", {0}}},
                             .task_options = {{"check_all", check_all ? 1.0 : 0.0}}},
                            constants};
  auto batch = test::make_running(id, options);
  test::step_at(*batch, kFarAway);
  return batch;
}

void put(Batch& batch, int battery, const Vector3d& where) {
  batch.state().place_prop(0, battery, where.data(), mjcf::kBatteryQuat.data(),
                           PropStatus::kAsleep);
  test::step_at(batch, kFarAway);
}
int number(const Batch& batch, const char* name) {
  return *row<std::int32_t>(batch.output(name), 0);
}
void press(Batch& batch) {
  test::step_at(batch, kButton + Vector3d(0, 0, 0.07));
  test::step_at(batch, kFarAway);
}
// Whether battery 0 counts as inserted there.
bool inserts(const ConstantTable& constants, const Vector3d& offset) {
  const auto batch = make(kHard, constants);
  put(*batch, 0, kSocket + offset);
  return flag(*batch, "new_insert_event");
}
// Whether battery 0 counts as returned there.
bool returns(const ConstantTable& constants, const Vector3d& offset) {
  const auto batch = make(kHard, constants);
  put(*batch, 0, kSocket);
  put(*batch, 0, kSlot + offset);
  return flag(*batch, "new_return_event");
}

TEST_CASE("Numbers of batteries change scene, answers and success", "[variants][battery]") {
  const ConstantTable constants = {{"ACTIVE_BATTERY_COUNT", 5}, {"WORKING_BATTERY_COUNT", 2}};
  for (const bool easy : {true, false}) {
    const std::string id = easy ? "BatteriesCheckerEasy-6-VLA-v0" : "BatteriesCheckerHard-6-VLA-v0";
    const auto task = make_task(id, constants);
    const TaskInfo& info = task->info();
    CHECK(info.candidates == 10);
    CHECK(info.chance() == Approx(1 - 2 * std::pow(0.8, 5) + std::pow(0.6, 5)));
    CHECK(info.oracle_dim == 2);
    CHECK(test::constant_text(info, "ACTIVE_BATTERY_COUNT") == "5");
    CHECK(test::constant_text(info, "WORKING_BATTERY_COUNT") == "2");
    for (const RandomVariable& draw : info.random_variables) {
      if (draw.name == "working") CHECK((draw.width == 2 && draw.high == 4));
    }
    CHECK_THAT(task->document(), Contains("battery_4") && !Contains("battery_5"));
    const auto batch = test::make_running(id, MakeOptions{{}, constants});
    test::step(*batch, Policy::kZero);
    CHECK(batch->state_dim() == 189 + 2);
    CHECK(number(*batch, "active_battery_count") == 5);
    CHECK(number(*batch, "target_working_count") == 2);
  }
}

TEST_CASE("With check_all all batteries that take part have to be checked", "[variants][battery]") {
  for (const int batteries : {1, 2}) {
    const auto batch = make(kEasy, {{"ACTIVE_BATTERY_COUNT", batteries}}, true);
    for (int battery = 0; battery < batteries; ++battery) {
      CHECK_FALSE(flag(*batch, "success"));
      put(*batch, battery, kSocket);
      press(*batch);
    }
    CHECK(number(*batch, "checked_count") == batteries);
    CHECK(flag(*batch, "success"));
  }
}

TEST_CASE("A battery is inserted within the socket's tolerances", "[variants][battery]") {
  constexpr double kHair = 1e-6;
  for (const double tolerance : {0.004, 0.01, 0.05}) {
    INFO(tolerance);
    const ConstantTable constants = {{"SOCKET_INSERT_XY_TOL", tolerance}};
    CHECK(inserts(constants, {tolerance - kHair, 0, 0}));
    CHECK_FALSE(inserts(constants, {tolerance + kHair, 0, 0}));
  }
  for (const double tolerance : {0.011, 0.025, 0.1}) {
    INFO(tolerance);
    const ConstantTable constants = {{"SOCKET_INSERT_Z_TOL", tolerance}};
    CHECK(inserts(constants, {0, 0, tolerance - kHair}));
    CHECK_FALSE(inserts(constants, {0, 0, tolerance + kHair}));
  }
}

TEST_CASE("A battery is returned within its slot's tolerances", "[variants][battery]") {
  constexpr double kHair = 1e-6;
  for (const double tolerance : {0.005, 0.023, 0.04}) {
    INFO(tolerance);
    const ConstantTable constants = {{"SLOT_RETURN_XY_TOL", tolerance}};
    CHECK(returns(constants, {0, tolerance - kHair, 0}));
    CHECK_FALSE(returns(constants, {0, tolerance + kHair, 0}));
  }
  for (const double tolerance : {0.003, 0.024, 0.1}) {
    INFO(tolerance);
    const ConstantTable constants = {{"SLOT_RETURN_Z_TOL", tolerance}};
    CHECK(returns(constants, {0, 0, tolerance - kHair}));
    CHECK_FALSE(returns(constants, {0, 0, tolerance + kHair}));
  }
}

// A checked battery may stray three tolerances from its slot.
TEST_CASE("With check_all success goes by the slots' tolerance, too", "[variants][battery]") {
  for (const double tolerance : {0.005, 0.023}) {
    for (const bool near : {true, false}) {
      INFO(tolerance << " " << near);
      const auto batch =
          make(kEasy, {{"ACTIVE_BATTERY_COUNT", 1}, {"SLOT_RETURN_XY_TOL", tolerance}}, true);
      put(*batch, 0, kSocket);
      put(*batch, 0, kSlot + Vector3d(3 * tolerance + (near ? -1e-6 : 1e-6), 0, 0));
      press(*batch);
      CHECK(number(*batch, "checked_count") == 1);
      CHECK(flag(*batch, "success") == near);
    }
  }
}

TEST_CASE("The lamp stays on for LAMP_AFTERGLOW_STEPS", "[variants][battery]") {
  for (const int steps : {0, 1, 7, 30}) {
    INFO(steps);
    const auto batch = make(kEasy, {{"LAMP_AFTERGLOW_STEPS", steps}});
    put(*batch, 0, kSocket);  // and it is home again in the same step
    int lit = 0;
    for (int i = 0; i < 40; ++i) {
      lit += *row<std::uint8_t>(test::memory_of(*batch).find("lit"), 0);
      test::step_at(*batch, kFarAway);
    }
    CHECK(lit == std::max(1, steps));
  }
}

TEST_CASE("The button has the size of its constants", "[variants][battery]") {
  const ConstantTable constants = {{"BUTTON_BASE_HALF_SIZE", ConstantList{0.05, 0.06, 0.02}},
                                   {"BUTTON_CAP_RADIUS", 0.04}};
  const auto task = make_task(kHard, constants);
  CHECK(test::size_in(task->document(), "battery_button_base") == 0.05);
  CHECK(test::size_in(task->document(), "battery_button_cap") == 0.04);
  CHECK(test::constant_text(task->info(), "BUTTON_CAP_RADIUS") == "0.04");
}

TEST_CASE("The button is pressed within its radius, and at its height", "[variants][battery]") {
  const auto pressed = [](const ConstantTable& constants, double aside, double height) {
    const auto batch = make(kEasy, constants);
    test::step_at(*batch, kButton + Vector3d(aside, 0, height));
    return flag(*batch, "new_button_press_event");
  };
  for (const double radius : {0.02, 0.075, 0.13}) {
    INFO(radius);
    const ConstantTable constants = {{"BUTTON_PRESS_XY_RADIUS", radius}};
    CHECK(pressed(constants, radius - 1e-5, 0.07));
    CHECK_FALSE(pressed(constants, radius + 1e-5, 0.07));
  }
  for (const double margin : {0.015, 0.03, 0.08}) {
    INFO(margin);
    const ConstantTable constants = {{"BUTTON_PRESS_Z_MARGIN", margin}};
    const double height = 0.058 + margin - 0.35 * 0.014;
    CHECK(pressed(constants, 0, height - 1e-5));
    CHECK_FALSE(pressed(constants, 0, height + 1e-5));
  }
}

TEST_CASE("Penalties of BatteriesChecker have the weights of their constants",
          "[variants][battery]") {
  const auto reward = [](const ConstantTable& constants) {
    const auto batch = make(kEasy, constants);
    std::vector<float> action = test::zeros(*batch);
    action[0] = 1;
    test::pose_tool(*batch, kFarAway);
    batch->step(action);
    return batch->outputs().reward[0];
  };
  CHECK(reward({}) - reward({{"ACTION_DELTA_L2_COEF", 1}}) ==
        Approx(0.98 * std::tanh(5.0)).margin(1e-5));
}

TEST_CASE("Sets of BatteriesChecker that contradict themselves are refused",
          "[variants][battery]") {
  struct Case {
    ConstantTable constants;
    const char* message;
  };
  const std::vector<Case> cases = {
      {{{"WORKING_BATTERY_COUNT", 4}}, "4 given, at most ACTIVE_BATTERY_COUNT 3 allowed"},
      {{{"ACTIVE_BATTERY_COUNT", 16}}, "from 1 to 15"},
      {{{"ACTIVE_BATTERY_COUNT", 12}},
       "ACTIVE_BATTERY_COUNT 12 x 70 = 840 control steps, more than max_episode_steps 540"},
      {{{"SOCKET_INSERT_Z_TOL", 0.01}}, "from 0.011"},
      {{{"BUTTON_PRESS_XY_RADIUS", 0.14}}, "from the button to the nearest slot allowed"},
      {{{"BUTTON_CAP_RADIUS", 0.08}}, "half the base's side"},
      {{{"LAMP_AFTERGLOW_STEPS", 0.5}}, "a whole number"},
      {{{"REQUIRED_LIFT_HEIGHT", 0.1}}, "no constant named"},
  };
  for (const Case& refused : cases) {
    CHECK_THROWS_WITH(make_task(kEasy, refused.constants), Contains(refused.message));
  }
  CHECK_THROWS_WITH(make_task(kHard, {{"ACTIVE_BATTERY_COUNT", 10}}),
                    Contains("10 x 110 = 1100 control steps, more than max_episode_steps 1080"));
}

}  // namespace
}  // namespace engram
