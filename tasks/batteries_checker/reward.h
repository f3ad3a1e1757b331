// Checks of batteries, and the dense reward.
#pragma once

#include <Eigen/Dense>
#include <bit>
#include <cstdint>

#include "tasks/common/action_cost.h"

namespace engram::tasks {

// Sets of batteries: a bit per slot.
using BatterySet = std::uint32_t;

inline BatterySet battery_bit(int battery) { return BatterySet{1} << battery; }
inline bool contains(BatterySet set, int battery) { return (set & battery_bit(battery)) != 0; }
inline int count(BatterySet set) { return std::popcount(set); }
// The lowest index, -1 of an empty set.
inline int lowest(BatterySet set) { return set == 0 ? -1 : std::countr_zero(set); }

// Stages, named by what has to be done next.
inline constexpr int STAGE_INSERT = 0;
inline constexpr int STAGE_RETURN = 1;
inline constexpr int STAGE_CONFIRM = 2;

// State between evaluations.
struct CheckState {
  int stage = STAGE_INSERT;
  int active = -1;  // the battery that began this round, -1: none
  int afterglow = 0;
  BatterySet checked = 0;
  BatterySet found = 0;  // checked ones that work
};

// Inputs of an evaluation.
struct CheckInputs {
  BatterySet in_socket = 0;  // released there
  BatterySet home = 0;       // released in their own slots
  BatterySet working = 0;
  bool pressed = false;  // a press of the button begins
  int afterglow = 7;     // LAMP_AFTERGLOW_STEPS
};

struct CheckEvents {
  bool insert = false;
  bool returned = false;
  bool taken_out = false;  // returned by itself, out of the socket
  bool confirm = false;
  bool newly_found = false;  // a working battery has been confirmed for the first time
  int socket_battery = -1;   // -1: none
  bool socket_works = false;
  bool lamp = false;
};

// One evaluation of the stage machine.
CheckEvents check_step(const CheckInputs& inputs, CheckState& state);

// Easy: the battery that was inserted is back in its slot in the same evaluation. True if so; it is
// then no longer in the socket.
bool return_by_itself(CheckState& state, CheckEvents& events);

inline constexpr double kBatterySuccessReward = 40;

// Dense reward (tasks/common/reward_dict.h). Distances in m; negative where there is nothing to
// measure.
struct BatteryReward {
  int stage = STAGE_INSERT;        // after this step's transitions
  double unchecked_distance = -1;  // TCP to the nearest unchecked battery
  double carry_distance = -1;      // battery in the hand to the socket
  double home_distance = 0;        // active battery to its slot
  double button_distance = 0;      // TCP to the point above the button
  double socket_distance = 0;      // TCP to the socket
  double press_depth = 0;          // of the button, as a fraction of its travel
  bool pressed = false;
  CheckEvents events = {};
  int checked = 0;  // batteries
  int found = 0;    // working ones that were checked
  int working = 0;  // all working ones
  ActionCost action_cost = {};
  bool success = false;
  SmoothnessParams smoothness = {};
  bool upstream = false;  // with the three terms that differ from what is meant
  // Terms.
  double reach = 0;
  double carry = 0;
  double back = 0;
  double button_reach = 0;
  double press = 0;
  bool newly_found = false;
  bool wrong_press = false;
  SmoothnessTerms smooth = {};

  double compute();
  template <class Visitor>
  void list_terms(Visitor& row) const {
    row.term("stage_insert", "", stage == STAGE_INSERT);
    row.term("stage_return", "", stage == STAGE_RETURN);
    row.term("stage_confirm", "", stage == STAGE_CONFIRM);
    row.term("reach_unchecked_reward", "", reach);
    row.term("carry_to_socket_reward", "", carry);
    row.term("return_reward", "", back);
    row.term("button_reach_reward", "", button_reach);
    row.term("button_press_reward", "", press);
    row.term("new_insert_event", "", events.insert);
    row.term("new_return_event", "", events.returned);
    row.term("new_confirm_event", "", events.confirm);
    row.term("newly_found_working", "", newly_found);
    row.term("wrong_phase_press", "", wrong_press);
    row.term("checked_count", "", checked);
    row.term("found_working_count", "", found);
    row.term("target_working_count", "", working);
    smooth.list_terms(row);
  }
};

}  // namespace engram::tasks
