// Checks batteries one after another. Nothing is remembered between steps.
#pragma once

#include "tasks/batteries_checker/rack.h"
#include "tasks/common/press_button.h"

namespace engram::tasks {

// What an agent chooses in one round.
struct BatteryChoice {
  int battery = -1;        // to be tested, -1: none
  int active = -1;         // to be returned into its slot
  bool keep_down = false;  // the button, until the next round
};

class BatteryOracle {
 public:
  static constexpr double kOpening = 0.4;  // gripper command: 25 mm per finger

  BatteryOracle(const BatteryRack& rack, const PressButton& button)
      : rack_(rack), button_(button) {}

  // Writes the next action of a round that is in that stage.
  void act(const State& state, int env, int stage, const BatteryChoice& choice,
           float* action) const;

 private:
  void insert(const State& state, int env, int battery, float* action) const;
  // True once the battery stands in its slot and the tool is clear of it.
  bool put_back(const State& state, int env, int battery, float* action) const;
  // True if nothing is between the fingers.
  bool clear_tool(const State& state, int env, float* action) const;
  void press(const State& state, int env, bool keep_down, float* action) const;

  const BatteryRack& rack_;
  const PressButton& button_;
};

}  // namespace engram::tasks
