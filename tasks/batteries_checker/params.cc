#include "tasks/batteries_checker/params.h"

#include <array>

#include "core/base/error.h"
#include "core/base/index.h"
#include "core/base/join.h"
#include "tasks/batteries_checker/reward.h"
#include "tasks/common/colors.h"
#include "tasks/common/lamp.h"

namespace engram::tasks {
namespace {

// Number of ways to choose some of n; 0 of more than n.
double choose(int n, int some) {
  if (some > n) return 0;
  double ways = 1;
  for (int i = 1; i <= some; ++i) ways = ways * (n - some + i) / i;
  return ways;
}

// An agent that does not remember what it has tested takes a battery at random in every round.
// Where one has to go back to is no secret: batteries fill the same slots in every episode, and
// there is one hole in them.

// Probability that as many rounds as there are batteries find all that work.
double find_rate(const BatteryParams& params) {
  const int batteries = params.ACTIVE_BATTERY_COUNT;
  const int working = params.WORKING_BATTERY_COUNT;
  const auto share = [&](int some) { return static_cast<double>(some) / batteries; };
  std::array<double, NUM_BATTERIES + 1> has_found = {1};  // probability, by number
  for (int round = 0; round < batteries; ++round) {
    for (int found = working; found > 0; --found) {
      has_found[at(found)] = has_found[at(found)] * (1 - share(working - found)) +
                             has_found[at(found - 1)] * share(working - found + 1);
    }
    has_found[0] *= 1 - share(working);
  }
  return has_found[at(working)];
}

// Rate of a check of all batteries, each of which then has to be taken once.
double check_rate(const BatteryParams& params) {
  const int batteries = params.ACTIVE_BATTERY_COUNT;
  double rate = 1;
  for (int i = 1; i <= batteries; ++i) rate *= static_cast<double>(i) / batteries;
  return rate;
}

// Probability that the last one that works is found before any battery is taken twice.
double find_rate_without_repetition(const BatteryParams& params) {
  const int batteries = params.ACTIVE_BATTERY_COUNT;
  const int working = params.WORKING_BATTERY_COUNT;
  double rate = 0;
  double all_differ = 1;
  for (int rounds = 1; rounds <= batteries; ++rounds) {
    all_differ *= static_cast<double>(batteries - rounds + 1) / batteries;
    rate += all_differ * choose(rounds - 1, working - 1) / choose(batteries, working);
  }
  return rate;
}

ConstantList list(const mjcf::Vec3& values) { return {values[0], values[1], values[2]}; }

void declare_rack(ConstantBinder& constants) {
  const mjcf::BatteryShape battery;
  const mjcf::TrayShape tray;
  const mjcf::SocketShape socket;
  constants.fixed({{"NUM_BATTERIES", NUM_BATTERIES},
                   {"TRAY_ROWS", TRAY_ROWS},
                   {"TRAY_COLS", TRAY_COLS},
                   {"SLOT_SPACING_X", SLOT_SPACING_X},
                   {"SLOT_SPACING_Y", SLOT_SPACING_Y},
                   {"BATTERY_RADIUS", battery.BATTERY_RADIUS},
                   {"BATTERY_HALF_HEIGHT", battery.BATTERY_HALF_HEIGHT},
                   {"BATTERY_COLOR", published_color(battery.BATTERY_COLOR)},
                   {"BATTERY_STATIC_FRICTION", battery.BATTERY_FRICTION},
                   {"BATTERY_DYNAMIC_FRICTION", battery.BATTERY_FRICTION},
                   {"BATTERY_RESTITUTION", 0.0},
                   {"TRAY_HALF_HEIGHT", tray.half_size[2]},
                   {"TRAY_PADDING_X", 0.028},
                   {"TRAY_PADDING_Y", 0.026},
                   {"TRAY_COLOR", published_color(tray.TRAY_COLOR)},
                   {"SLOT_VISUAL_COLOR", published_color(tray.SLOT_VISUAL_COLOR)},
                   {"SOCKET_HALF_SIZE", list(socket.SOCKET_HALF_SIZE)},
                   {"SOCKET_SLOT_RADIUS", socket.SOCKET_SLOT_RADIUS},
                   {"SOCKET_COLOR", published_color(socket.SOCKET_COLOR)},
                   {"SOCKET_SLOT_COLOR", published_color(socket.SOCKET_SLOT_COLOR)},
                   {"SOCKET_X_OFFSET_FROM_TRAY", SOCKET_X_OFFSET_FROM_TRAY}});
}

void declare_button_and_lamp(ConstantBinder& constants) {
  constants.fixed({{"BUTTON_X_OFFSET_FROM_TRAY", BUTTON_X_OFFSET_FROM_TRAY},
                   {"BUTTON_Y_OFFSET_FROM_TRAY", BUTTON_Y_OFFSET_FROM_TRAY},
                   {"LAMP_X_OFFSET_FROM_SOCKET", LAMP_X_OFFSET_FROM_SOCKET},
                   {"LAMP_Y_OFFSET_FROM_SOCKET", LAMP_Y_OFFSET_FROM_SOCKET},
                   {"LAMP_HEIGHT", 0.0}});
  declare_lamp(constants);
  constants.fixed({{"LAMP_OFF_COLOR", published_color(LAMP_OFF_COLOR)},
                   {"LAMP_ON_COLOR", published_color(LAMP_ON_COLOR)}});
}

}  // namespace

// --- constants ---

void BatteryParams::declare(ConstantBinder& constants) {
  constants.integer("ACTIVE_BATTERY_COUNT", ACTIVE_BATTERY_COUNT, {1, NUM_BATTERIES}, "",
                    "batteries to be tested");
  constants.integer("WORKING_BATTERY_COUNT", WORKING_BATTERY_COUNT, {1, NUM_BATTERIES}, "",
                    "how many of them work");
  declare_rack(constants);
  constants.real("SOCKET_INSERT_XY_TOL", SOCKET_INSERT_XY_TOL, {0.004, 0.05}, "m",
                 "how near the socket's axis an inserted battery has to be");
  // A battery that stands in the socket is 10.5 mm above the height from which this is measured.
  constants.real("SOCKET_INSERT_Z_TOL", SOCKET_INSERT_Z_TOL, {0.011, 0.1}, "m",
                 "how near the socket's height its centre has to be");
  constants.real("SLOT_RETURN_XY_TOL", SLOT_RETURN_XY_TOL, {0.005, 0.04}, "m",
                 "how near its slot's axis a returned battery has to be");
  constants.real("SLOT_RETURN_Z_TOL", SLOT_RETURN_Z_TOL, {0.003, 0.1}, "m",
                 "how near its slot's height its centre has to be");
  declare_button_and_lamp(constants);
  constants.integer("LAMP_AFTERGLOW_STEPS", LAMP_AFTERGLOW_STEPS, {0, 1000}, "control steps",
                    "how long the lamp stays on after a working battery was inserted");
  constants.fixed({{"STAGE_INSERT", STAGE_INSERT},
                   {"STAGE_RETURN", STAGE_RETURN},
                   {"STAGE_CONFIRM", STAGE_CONFIRM},
                   {"HEIGHT_OFFSET", kHiddenOffset},
                   {"SUCCESS_BONUS", kBatterySuccessReward}});
  button.declare(constants);
  smoothness.declare(constants);
}

void BatteryParams::check(int horizon) const {
  if (WORKING_BATTERY_COUNT > ACTIVE_BATTERY_COUNT) {
    refuse_constant(
        "WORKING_BATTERY_COUNT", std::to_string(WORKING_BATTERY_COUNT),
        "at most ACTIVE_BATTERY_COUNT " + std::to_string(ACTIVE_BATTERY_COUNT) + " allowed");
  }
  button.check();
  constexpr double kSlotToButton = BUTTON_Y_OFFSET_FROM_TRAY - TRAY_ROWS / 2 * SLOT_SPACING_X;
  if (button.BUTTON_PRESS_XY_RADIUS > kSlotToButton) {
    refuse_constant("BUTTON_PRESS_XY_RADIUS", shortest(button.BUTTON_PRESS_XY_RADIUS),
                    "at most the " + shortest(kSlotToButton) +
                        " m from the button to the nearest slot allowed");
  }
  const int per_battery = easy ? 70 : 110;  // control steps
  const int least = per_battery * ACTIVE_BATTERY_COUNT;
  if (least <= horizon) return;
  throw Error(Error::kInvalidArgument,
              "constants leave no time to act: ACTIVE_BATTERY_COUNT " +
                  std::to_string(ACTIVE_BATTERY_COUNT) + " x " + std::to_string(per_battery) +
                  " = " + std::to_string(least) + " control steps, more than max_episode_steps " +
                  std::to_string(horizon));
}

BatteryVariables::BatteryVariables(RandomVariables list, const BatteryParams& params)
    : tray_x(list.real("tray_x", kTrayX, "m", "centre of the tray")),
      tray_y(list.real("tray_y", kTrayY, "m", "centre of the tray")),
      working(list.add({"working", params.WORKING_BATTERY_COUNT, true, 0,
                        params.ACTIVE_BATTERY_COUNT - 1.0, "", "slots of the batteries that work",
                        true})) {}

BatteryOptions::BatteryOptions(TaskOptions list)
    : check_all(list.on_off("check_all",
                            "1: success needs every battery checked, and none of them lost",
                            /*original=*/true)),
      upstream_rewards(
          list.on_off("upstream_rewards",
                      "1: button reach, found bonus and press penalty as in upstream's code",
                      /*original=*/true)),
      socket_battery_idx(
          list.add({"socket_battery_idx", -1, true, -1, 0, "",
                    "what the info field of that name says of an empty socket", 0})) {}

void describe_chance(const BatteryParams& params, bool check_all, TaskInfo& info) {
  info.candidates =
      static_cast<int>(choose(params.ACTIVE_BATTERY_COUNT, params.WORKING_BATTERY_COUNT));
  info.guess_rate = check_all ? check_rate(params) : find_rate(params);
  info.answer_rate = check_all ? check_rate(params) : find_rate_without_repetition(params);
}

void describe_batteries(const BatteryParams& params, TaskInfo& info) {
  describe_chance(params, false, info);
  info.answer =
      "the first press of the button with a battery out of its slot or checked before (wrong), or "
      "the one that ends the search (right); the battery";
  info.termination = Termination::kSuccess;
  info.success_reward = kBatterySuccessReward;
  info.oracle_dim = params.WORKING_BATTERY_COUNT;
  info.hidden_variable = "working";
  info.phases = {{"insert", "until a battery stands in the socket"},
                 {"return", params.easy ? "over at once: the battery returns by itself"
                                        : "until that battery stands in its own slot again"},
                 {"confirm", "until the button is pressed"}};
}

}  // namespace engram::tasks
