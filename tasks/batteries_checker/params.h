// Constants, variants and descriptions of BatteriesChecker.
#pragma once

#include <array>

#include "core/task/task.h"
#include "mjcf/battery.h"
#include "tasks/common/action_cost.h"
#include "tasks/common/press_button.h"
#include "tasks/common/random_variables.h"
#include "tasks/common/task_options.h"
#include "tasks/family.h"

namespace engram::tasks {

constexpr PressButtonParams battery_button() {
  return {.shape = {.BUTTON_BASE_HALF_SIZE = {0.075, 0.075, 0.015},
                    .BUTTON_CAP_RADIUS = 0.033,
                    .base_rgba = {58 / 255.0, 66 / 255.0, 80 / 255.0, 1},
                    .cap_rgba = {205 / 255.0, 110 / 255.0, 110 / 255.0, 1}},
          .BUTTON_PRESS_XY_RADIUS = 0.075,
          .radius_counts = true};
}

struct BatteryParams {
  TaskSpec task;
  bool easy;  // an inserted battery returns by itself
  int ACTIVE_BATTERY_COUNT;
  int WORKING_BATTERY_COUNT;
  double SOCKET_INSERT_XY_TOL = 0.010;  // m
  double SOCKET_INSERT_Z_TOL = 0.025;   // m
  double SLOT_RETURN_XY_TOL = 0.023;    // m
  double SLOT_RETURN_Z_TOL = 0.024;     // m
  int LAMP_AFTERGLOW_STEPS = 7;
  PressButtonParams button = battery_button();
  SmoothnessParams smoothness = {
      .ACTION_L2_COEF = 0.01, .ACTION_DELTA_L2_COEF = 0.02, .QVEL_L2_COEF = 0.01};

  void declare(ConstantBinder& constants);
  void check(int horizon) const;
};

inline constexpr std::array<BatteryParams, 5> kEasyVariants = {{
    {{"BatteriesCheckerEasy-12-VLA-v0", 2160, Split::kExtended, 0.90}, true, 12, 7},
    {{"BatteriesCheckerEasy-15-VLA-v0", 2400, Split::kExtended, 0.90}, true, 15, 9},
    {{"BatteriesCheckerEasy-3-VLA-v0", 540, Split::kMedium, 0.90}, true, 3, 1},
    {{"BatteriesCheckerEasy-6-VLA-v0", 1080, Split::kLong, 0.90}, true, 6, 3},
    {{"BatteriesCheckerEasy-9-VLA-v0", 1620, Split::kExtended, 0.90}, true, 9, 5},
}};
inline constexpr std::array<BatteryParams, 5> kHardVariants = {{
    {{"BatteriesCheckerHard-12-VLA-v0", 4320, Split::kExtended, 0.75}, false, 12, 7},
    {{"BatteriesCheckerHard-15-VLA-v0", 4320, Split::kExtended, 0.75}, false, 15, 9},
    {{"BatteriesCheckerHard-3-VLA-v0", 1080, Split::kLong, 0.85}, false, 3, 1},
    {{"BatteriesCheckerHard-6-VLA-v0", 2160, Split::kLong, 0.85}, false, 6, 3},
    {{"BatteriesCheckerHard-9-VLA-v0", 3240, Split::kExtended, 0.75}, false, 9, 5},
}};

inline constexpr int TRAY_ROWS = 5;
inline constexpr int TRAY_COLS = 3;
inline constexpr int NUM_BATTERIES = TRAY_ROWS * TRAY_COLS;
inline constexpr double SLOT_SPACING_X = 0.052;            // m, from row to row: the world's y
inline constexpr double SLOT_SPACING_Y = 0.050;            // m, from column to column
inline constexpr double SOCKET_X_OFFSET_FROM_TRAY = 0.2;   // m
inline constexpr double BUTTON_X_OFFSET_FROM_TRAY = 0.0;   // m
inline constexpr double BUTTON_Y_OFFSET_FROM_TRAY = 0.24;  // m
inline constexpr double LAMP_X_OFFSET_FROM_SOCKET = 0.08;  // m
inline constexpr double LAMP_Y_OFFSET_FROM_SOCKET = 0.0;   // m
inline constexpr Interval<double> kTrayX{-0.09, -0.01};    // m
inline constexpr Interval<double> kTrayY{-0.05, 0.05};     // m
inline constexpr double kHiddenOffset = 1000;              // m
inline constexpr mjcf::Rgba LAMP_OFF_COLOR = {1, 1, 1, 1};
inline constexpr mjcf::Rgba LAMP_ON_COLOR = {1, 236 / 255.0, 110 / 255.0, 1};

// Random variables of an episode.
struct BatteryVariables {
  BatteryVariables(RandomVariables list, const BatteryParams& params);

  RealVariable tray_x;
  RealVariable tray_y;
  VariableHandle working;
};

struct BatteryOptions {
  explicit BatteryOptions(TaskOptions list);

  TaskOption check_all;
  TaskOption upstream_rewards;
  TaskOption socket_battery_idx;
};

// Fills in TaskInfo, apart from what the registry knows, reward terms and state fields.
void describe_batteries(const BatteryParams& params, TaskInfo& info);
// Fills in candidates and rates of guessing.
void describe_chance(const BatteryParams& params, bool check_all, TaskInfo& info);

}  // namespace engram::tasks
