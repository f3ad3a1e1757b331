// The press that decides whether the checklist was kept is the answer.
#include <catch2/catch.hpp>

#include "mjcf/battery.h"
#include "tests/tasks/first_answer.h"
#include "tests/tasks/pose_tool.h"

namespace engram {
namespace {

using Eigen::Vector3d, test::first_answer, test::FirstAnswer, test::flag, test::row, test::step_at;

constexpr const char* kEasy = "BatteriesCheckerEasy-3-VLA-v0";
constexpr const char* kHard = "BatteriesCheckerHard-3-VLA-v0";
const Vector3d kSocket(0.15, 0.02, 0.03);
const Vector3d kButton(-0.05, 0.26, 0.07);
const Vector3d kFarAway(-0.1, 0, 0.4);

Vector3d slot(int battery) { return {-0.05 * battery, -0.084, 0.03}; }

// Battery 0 works. Everything stays where a test puts it.
std::unique_ptr<Batch> start(const char* id, bool strict = false, bool check_all = true) {
  const BatchOptions options{
      .auto_reset = AutoReset::kOff,
      .substeps = 0,
      .pins = {{"tray_x", {-0.05}}, {"tray_y", {0.02}}, {"working", {0}}},
      .task_options = {{kStrictOption, strict ? 1.0 : 0.0}, {"check_all", check_all ? 1.0 : 0.0}}};
  return test::make_running(id, options);
}

void put(Batch& batch, int battery, const Vector3d& where) {
  batch.state().place_prop(0, battery, where.data(), mjcf::kBatteryQuat.data());
  step_at(batch, kFarAway);
}
void press(Batch& batch) {
  step_at(batch, kButton);
  step_at(batch, kFarAway);
}
void check_off(Batch& batch, int battery) {
  put(batch, battery, kSocket);
  put(batch, battery, slot(battery));
  press(batch);
}
int checked(const Batch& batch) { return *row<std::int32_t>(batch.output("checked_count"), 0); }
TEST_CASE("Who checks every battery once has answered rightly with the last", "[battery][answer]") {
  for (const char* id : {kEasy, kHard}) {
    const auto batch = start(id, true);
    press(*batch);  // says nothing
    for (const int battery : {1, 0, 2}) {
      CHECK(first_answer(*batch) == FirstAnswer{});
      check_off(*batch, battery);
    }
    CHECK(first_answer(*batch) == FirstAnswer{true, 2, true});
    CHECK(flag(*batch, "success"));
  }
}

TEST_CASE("Who finds the last one that works has answered rightly", "[battery][answer]") {
  for (const char* id : {kEasy, kHard}) {
    const auto batch = start(id, true, false);
    check_off(*batch, 1);
    CHECK(first_answer(*batch) == FirstAnswer{});
    CHECK_FALSE(flag(*batch, "success"));
    check_off(*batch, 0);
    CHECK(first_answer(*batch) == FirstAnswer{true, 0, true});
    CHECK(flag(*batch, "success"));
  }
}

TEST_CASE("Who checks a dud twice before that has answered wrongly", "[battery][answer]") {
  for (const bool strict : {false, true}) {
    const auto batch = start(kEasy, strict, false);
    check_off(*batch, 1);
    check_off(*batch, 1);
    CHECK(first_answer(*batch) == FirstAnswer{true, 1, false});
    check_off(*batch, 0);
    CHECK(first_answer(*batch) == FirstAnswer{true, 1, false});
    CHECK(flag(*batch, "success") == !strict);
  }
}

TEST_CASE("Who checks a battery twice has answered wrongly", "[battery][answer]") {
  for (const char* id : {kEasy, kHard}) {
    for (const bool strict : {false, true}) {
      const auto batch = start(id, strict);
      check_off(*batch, 1);
      put(*batch, 1, kSocket);
      put(*batch, 1, slot(1));
      CHECK(first_answer(*batch) == FirstAnswer{});
      press(*batch);
      CHECK(first_answer(*batch) == FirstAnswer{true, 1, false});
      CHECK(flag(*batch, "failed") == strict);
      check_off(*batch, 0);
      check_off(*batch, 2);
      CHECK(checked(*batch) == 3);
      CHECK(first_answer(*batch) == FirstAnswer{true, 1, false});
      CHECK(flag(*batch, "success") == !strict);
    }
  }
}

TEST_CASE("Who presses with a battery out of its slot has answered wrongly", "[battery][answer]") {
  const auto batch = start(kHard);
  put(*batch, 2, kSocket);
  put(*batch, 2, slot(3));
  CHECK(first_answer(*batch) == FirstAnswer{});
  press(*batch);
  CHECK(checked(*batch) == 0);
  CHECK(first_answer(*batch) == FirstAnswer{true, 2, false});
}

}  // namespace
}  // namespace engram
