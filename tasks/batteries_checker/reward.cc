#include "tasks/batteries_checker/reward.h"

#include <algorithm>

#include "core/math/real_functions.h"

namespace engram::tasks {

CheckEvents check_step(const CheckInputs& inputs, CheckState& state) {
  CheckEvents events;
  events.socket_battery = lowest(inputs.in_socket);
  const bool occupied = events.socket_battery >= 0;
  events.socket_works = occupied && contains(inputs.working, events.socket_battery);

  state.afterglow = std::max(0, state.afterglow - 1);
  if (state.stage == STAGE_INSERT && occupied) {
    events.insert = true;
    state.stage = STAGE_RETURN;
    state.active = events.socket_battery;
    if (events.socket_works) state.afterglow = inputs.afterglow;
  }
  events.lamp = events.socket_works || state.afterglow > 0;

  if (state.stage == STAGE_RETURN && state.active >= 0 && contains(inputs.home, state.active)) {
    events.returned = true;
    state.stage = STAGE_CONFIRM;
  }
  if (state.stage == STAGE_CONFIRM && inputs.pressed) {
    events.confirm = true;
    const bool works = contains(inputs.working, state.active);
    events.newly_found = works && !contains(state.checked, state.active);
    state.checked |= battery_bit(state.active);
    if (works) state.found |= battery_bit(state.active);
    state.stage = STAGE_INSERT;
    state.active = -1;
  }
  return events;
}

bool return_by_itself(CheckState& state, CheckEvents& events) {
  if (state.stage != STAGE_RETURN || state.active < 0) return false;
  state.stage = STAGE_CONFIRM;
  events.returned = true;
  events.taken_out = true;
  events.socket_battery = -1;
  events.socket_works = false;
  return true;
}

double BatteryReward::compute() {
  const auto nearness = [](double sharpness, double distance) {
    return distance < 0 ? 0.0 : 1 - real::tanh(sharpness * distance);
  };
  reach = nearness(4, unchecked_distance);
  carry = nearness(4, carry_distance);
  back = nearness(6, home_distance);
  button_reach = nearness(8, upstream ? socket_distance : button_distance);
  press = std::clamp(press_depth, 0.0, 1.0);
  newly_found = !upstream && events.newly_found;
  wrong_press = pressed && stage != STAGE_CONFIRM && (upstream || !events.confirm);
  smooth = tasks::smoothness(action_cost, smoothness);
  if (success) return kBatterySuccessReward;

  double reward = -smooth.penalty;
  if (stage == STAGE_INSERT) reward += 1.2 * reach + 2.0 * carry;
  if (stage == STAGE_RETURN) reward += 3.0 * back;
  if (stage == STAGE_CONFIRM) reward += 1.8 * button_reach + 2.5 * press;
  if (events.insert) reward += 5;
  if (events.returned) reward += 6;
  if (events.confirm) reward += 7;
  if (newly_found) reward += 12;
  if (wrong_press) reward -= 2;
  return reward;
}

}  // namespace engram::tasks
