#include "tasks/batteries_checker/check_columns.h"

namespace engram::tasks {

void CheckColumns::bind(const Bindings& bindings, int batteries) {
  ColumnStore& memory = *bindings.memory;
  working_set = memory.add<std::int32_t>("working", 1, "", "a bit per slot");
  checked_set = memory.add<std::int32_t>("checked", 1, "", "a bit per slot");
  found_set = memory.add<std::int32_t>("found", 1, "", "a bit per slot");
  grasped_set = memory.add<std::int32_t>("grasped", 1, "", "a bit per slot");
  afterglow = memory.add<std::int32_t>("afterglow", 1, "control steps");
  rounds = memory.add<std::int32_t>("rounds", 1, "", "confirmations so far");
  lit = memory.add<std::uint8_t>("lit");
  newly_found = memory.add<std::uint8_t>("newly_found");
  solved = memory.add<std::uint8_t>("solved");
  const int all = (1 << batteries) - 1;
  for (const char* set : {"working", "checked", "found", "grasped"}) memory.limit(set, 0, all);
  ColumnStore& info = *bindings.outputs;
  action_mask = info.add<std::uint8_t>("action_mask", 1, "", "always true");
  cue_mask = info.add<std::uint8_t>("cue_mask", 1, "", "always false");
  stage = info.add<std::int32_t>("action_stage", 1, "", "0: insert, 1: return, 2: confirm");
  active = info.add<std::int32_t>("active_battery_idx", 1, "", "of this round, -1: none");
  socket_has_battery = info.add<std::uint8_t>("socket_has_battery");
  socket_idx =
      info.add<std::int32_t>("socket_battery_idx", 1, "",
                             "none: as the option of that name says; -1 if it returned by itself");
  socket_works = info.add<std::uint8_t>("socket_has_working");
  active_count = info.add<std::int32_t>("active_battery_count");
  checked_count = info.add<std::int32_t>("checked_count");
  found_count = info.add_privileged<std::int32_t>("found_working_count");
  target_count = info.add<std::int32_t>("target_working_count");
  all_checked = info.add<std::uint8_t>("all_checked");
  insert_event = info.add<std::uint8_t>("new_insert_event");
  return_event = info.add<std::uint8_t>("new_return_event");
  confirm_event = info.add<std::uint8_t>("new_confirm_event");
  press_event = info.add<std::uint8_t>("new_button_press_event");
  press_depth = info.add<float>("button_press_depth", 1, "m");
  obj_to_goal_pos =
      info.add_privileged<float>("obj_to_goal_pos", 3, "m", "socket minus TCP position");
  info.limit("action_stage", 0, 2);
  info.limit("active_battery_idx", -1, batteries - 1);
  info.limit("socket_battery_idx", -1, batteries - 1);
}

CheckState CheckColumns::load(int env) const {
  return {stage[env], active[env], afterglow[env], checked(env), found(env)};
}

void CheckColumns::store(int env, const CheckState& state) const {
  stage[env] = state.stage;
  active[env] = state.active;
  afterglow[env] = state.afterglow;
  checked_set[env] = static_cast<std::int32_t>(state.checked);
  found_set[env] = static_cast<std::int32_t>(state.found);
}

void CheckColumns::store(int env, const CheckEvents& events, bool pressed) const {
  insert_event[env] = events.insert ? 1 : 0;
  return_event[env] = events.returned ? 1 : 0;
  confirm_event[env] = events.confirm ? 1 : 0;
  newly_found[env] = events.newly_found ? 1 : 0;
  press_event[env] = pressed ? 1 : 0;
  const bool found_empty = events.socket_battery < 0 && !events.taken_out;
  socket_idx[env] = found_empty ? empty_socket_idx : events.socket_battery;
  socket_has_battery[env] = events.socket_battery >= 0 ? 1 : 0;
  socket_works[env] = events.socket_works ? 1 : 0;
  lit[env] = events.lamp ? 1 : 0;
}

}  // namespace engram::tasks
