// What the oracle does with the gripper while it waits for the cue and a delay to end, and after:
// as the original's demonstrations do, for whoever learns from the wrist camera.
#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <string>
#include <vector>

#include "tests/env_helpers.h"

namespace engram {
namespace {

using test::make_running;

constexpr float kOpen = 1;
constexpr float kClosed = -0.6F;
constexpr float kCubeWide = 0.22F;
constexpr float kDepends = -9;  // on what stands beside

constexpr std::size_t kGripper = 6;  // of an action

struct Habit {
  const char* family;
  float waiting;
  float moving;       // when the hand begins to move
  float moving_long;  // the same in Long ids
};

// Families whose episodes begin with a wait.
constexpr std::array kHabits = {
    Habit{"RememberColor", kOpen, kClosed, kDepends},
    Habit{"RememberShape", kOpen, kClosed, kDepends},
    Habit{"RememberShapeAndColor", kOpen, kClosed, kDepends},
    Habit{"FindImposterColor", kOpen, kClosed, kClosed},
    Habit{"FindImposterShape", kOpen, kClosed, kClosed},
    Habit{"FindImposterShapeAndColor", kOpen, kClosed, kClosed},
    Habit{"ShellGameTouch", kOpen, kClosed, kClosed},
    Habit{"ShellGamePush", kOpen, kClosed, kClosed},
    Habit{"ShellGameColorLampTouch", kOpen, kClosed, kClosed},
    Habit{"ShellGameShuffleTouch", kOpen, kClosed, kOpen},
    Habit{"ShellGameShuffleColorLampTouch", kOpen, kClosed, kOpen},
    Habit{"BunchOfColors", kOpen, kOpen, kOpen},
    Habit{"SeqOfColors", kOpen, kOpen, kOpen},
    Habit{"ChainOfColors", kOpen, kOpen, kOpen},
    Habit{"BlinkCountButtonPress", kClosed, kClosed, kClosed},
    Habit{"TraceShape", kCubeWide, kOpen, kOpen},
    Habit{"TraceShapeSeq", kCubeWide, kOpen, kOpen},
};

bool rests(const float* action) {
  for (std::size_t i = 0; i < kGripper; ++i) {
    if (action[i] != 0) return false;
  }
  return true;
}

void check_habit(const Habit& habit, const std::string& id) {
  INFO(id);
  // RL tasks do not freeze the cue either.
  const bool is_long =
      id.find("-Long-") != std::string::npos || require_entry(id).split == Split::kRl;
  const auto batch = make_running(id, {.control_mode = ControlMode::kPdEeDeltaPose});
  const bool frozen = batch->info().frozen_cue;
  int waited = 0;
  while (true) {
    const std::vector<float> action = test::act(*batch, Policy::kOracle);
    if (!rests(action.data())) {
      const float expected = is_long ? habit.moving_long : habit.moving;
      if (expected != kDepends) CHECK(action[kGripper] == expected);
      break;
    }
    REQUIRE(action[kGripper] == habit.waiting);
    ++waited;
    batch->step(action);
    REQUIRE(batch->outputs().truncated[0] == 0);
    // Where the cue is frozen, zeros are played instead: half closed.
    const double* fingers = batch->state().qpos.row(0) + kArmJoints;
    if (frozen || habit.waiting != kOpen) continue;
    REQUIRE(fingers[0] > 0.0399);
    REQUIRE(fingers[1] > 0.0399);
  }
  CHECK(waited > 0);
}

TEST_CASE("While it waits the oracle holds its gripper as the demonstrations do",
          "[oracle][gripper]") {
  for (const Habit& habit : kHabits) {
    const std::vector<std::string> ids = test::implemented_ids(habit.family);
    REQUIRE_FALSE(ids.empty());
    for (const std::string& id : ids) {
      // The RL tasks of the colours lower the hand meanwhile (tests/tasks/colors).
      const bool lowers = require_entry(id).split == Split::kRl && id.find("OfColors") < id.size();
      if (!lowers) check_habit(habit, id);
    }
  }
}

TEST_CASE("Long Remember: the fingers stay open, but for neighbours of what is touched",
          "[oracle][gripper]") {
  for (const bool crowded : {false, true}) {
    BatchOptions options;
    const double beside = crowded ? 0.07 : 0.15;
    options.pins = {{"target", {0}},
                    {"cue_steps", {10}},
                    {"empty_steps", {50}},
                    {"positions", {0, 0.2, 0, 0.2 - beside, 0, -0.2}}};
    const auto batch = make_running("RememberColor3-Long-VLA-v0", options);
    const auto away = [&batch] { return std::abs(batch->state().tcp_pos.row(0)[1] - 0.2); };
    while (batch->outputs().success[0] == 0) {
      const std::vector<float> action = test::act(*batch, Policy::kOracle);
      INFO("crowded " << crowded << ", " << away() << " m away");
      REQUIRE(action[kGripper] == (crowded && away() < 0.11 ? kClosed : kOpen));
      do {
        batch->step(action);  // over the band in which it closes
      } while (away() > 0.11 && away() < 0.125 && batch->outputs().success[0] == 0);
      REQUIRE(batch->outputs().truncated[0] == 0);
    }
    const double finger = batch->state().qpos.row(0)[kArmJoints];
    CHECK((crowded ? finger < 0.01 : finger > 0.0395));
  }
}

TEST_CASE("The colour tasks' oracle closes its fingers for the button alone", "[oracle][gripper]") {
  const auto batch = make_running("BunchOfColors3-VLA-v0");
  bool closed = false;
  while (batch->outputs().success[0] == 0) {
    const std::vector<float> action = test::act(*batch, Policy::kOracle);
    const bool touched_all = *test::row<std::uint8_t>(batch->output("button_pressable"), 0) != 0;
    closed = closed || action[kGripper] == kClosed;
    if (action[kGripper] == kClosed) CHECK(touched_all);
    batch->step(action);
    REQUIRE(batch->outputs().truncated[0] == 0);
  }
  CHECK(closed);
}

TEST_CASE("Open fingers nudge no coloured cube", "[oracle][gripper]") {
  for (const char* id : {"BunchOfColors7-VLA-v0", "ChainOfColors5-VLA-v0"}) {
    const auto batch =
        make_running(id, {.num_envs = 30, .threads = 2, .auto_reset = AutoReset::kOff});
    std::vector<bool> acting(30);
    double moved = 0;
    for (int step = 0; step < batch->info().horizon; ++step) {
      const std::vector<float> actions = test::act(*batch, Policy::kOracle);
      batch->step(actions);
      for (std::size_t i = 0; i < acting.size(); ++i) {
        acting[i] = acting[i] || !rests(actions.data() + 7 * i);
        if (!acting[i]) continue;
        const ColumnView displacement = batch->output("max_cube_displacement_xy");
        const auto largest = *test::row<float>(displacement, static_cast<int>(i));
        moved = std::max(moved, static_cast<double>(largest));
      }
    }
    INFO(id);
    CHECK(moved < 0.002);
  }
}

}  // namespace
}  // namespace engram
