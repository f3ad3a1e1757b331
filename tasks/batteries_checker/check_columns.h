// Memory of the checks of BatteriesChecker, and the info fields that show them.
#pragma once

#include "core/task/task.h"
#include "tasks/batteries_checker/reward.h"

namespace engram::tasks {

struct CheckColumns {
  void bind(const Bindings& bindings, int batteries);

  CheckState load(int env) const;
  void store(int env, const CheckState& state) const;
  // `pressed`: a press of the button began in this evaluation.
  void store(int env, const CheckEvents& events, bool pressed) const;

  BatterySet working(int env) const { return static_cast<BatterySet>(working_set[env]); }
  BatterySet checked(int env) const { return static_cast<BatterySet>(checked_set[env]); }
  BatterySet found(int env) const { return static_cast<BatterySet>(found_set[env]); }
  BatterySet held(int env) const { return static_cast<BatterySet>(grasped_set[env]); }

  int empty_socket_idx = -1;  // socket_idx of a socket that was empty

  // Remembered.
  Column<std::int32_t> working_set;
  Column<std::int32_t> checked_set;
  Column<std::int32_t> found_set;
  Column<std::int32_t> grasped_set;  // as read before any teleport of this step
  Column<std::int32_t> afterglow;
  Column<std::int32_t> rounds;
  Column<std::uint8_t> lit;
  Column<std::uint8_t> newly_found;
  Column<std::uint8_t> solved;
  // Shown.
  Column<std::uint8_t> action_mask;
  Column<std::uint8_t> cue_mask;
  Column<std::int32_t> stage;
  Column<std::int32_t> active;
  Column<std::uint8_t> socket_has_battery;
  Column<std::int32_t> socket_idx;
  Column<std::uint8_t> socket_works;
  Column<std::int32_t> active_count;
  Column<std::int32_t> checked_count;
  Column<std::int32_t> found_count;
  Column<std::int32_t> target_count;
  Column<std::uint8_t> all_checked;
  Column<std::uint8_t> insert_event;
  Column<std::uint8_t> return_event;
  Column<std::uint8_t> confirm_event;
  Column<std::uint8_t> press_event;
  Column<float> press_depth;
  Column<float> obj_to_goal_pos;  // (3) m
};

}  // namespace engram::tasks
