#include "tasks/batteries_checker/annotator.h"

#include <algorithm>

#include "tasks/common/words.h"

namespace engram::tasks {
namespace {

std::string name(int battery) { return "battery " + std::to_string(battery + 1); }

}  // namespace

// All batteries in the order of their slots. An episode may end before the last one.
std::vector<std::string> BatteryAnnotator::plan(int /*env*/) const {
  std::vector<std::string> plan;
  for (int battery = 0; battery < view_.rack.batteries(); ++battery) {
    plan.push_back("put " + name(battery) + " into the socket and look at the lamp");
    if (!view_.params.easy) plan.push_back("put " + name(battery) + " back into its slot");
    plan.emplace_back("press the button");
  }
  return plan;
}

// The one that is being checked: it has been inserted, or is in the hand; else the next one.
int BatteryAnnotator::battery(int env) const {
  const CheckState state = view_.check.load(env);
  if (state.active >= 0) return state.active;
  const BatterySet all = battery_bit(view_.rack.batteries()) - 1;
  const BatterySet left = all & ~state.checked;
  const int held = lowest(view_.check.held(env) & left);
  return held >= 0 ? held : std::max(0, lowest(left));
}

int BatteryAnnotator::done_of_check(int env) const {
  const int stage = view_.check.load(env).stage;
  if (stage == STAGE_INSERT) return 0;
  return stage == STAGE_CONFIRM ? per_battery() - 1 : 1;
}

int BatteryAnnotator::subtask(int env) const {
  return per_battery() * battery(env) + done_of_check(env);
}

int BatteryAnnotator::subtasks_done(int env) const {
  return per_battery() * count(view_.check.checked(env)) + done_of_check(env);
}

// The lamp shows at once whether the battery in the socket works.
std::string BatteryAnnotator::memory(int env) const {
  const CheckState state = view_.check.load(env);
  BatterySet seen = state.checked;
  if (state.active >= 0) seen |= battery_bit(state.active);
  std::vector<std::string> items;
  for (int battery = 0; battery < view_.rack.batteries(); ++battery) {
    if (!contains(seen, battery)) continue;
    const bool works = contains(view_.check.working(env), battery);
    items.push_back(name(battery) + (works ? " works" : " does not work"));
  }
  return enumerate(items);
}

int BatteryAnnotator::object(int env) const {
  if (view_.check.load(env).stage == STAGE_CONFIRM) return view_.button.cap();
  return view_.rack.prop(battery(env));
}

}  // namespace engram::tasks
