// GatherAndRecall in numbers: parameters, draws and constants (docs/tasks/gather_and_recall.md).
#pragma once

#include <array>

#include "core/task/task.h"
#include "mjcf/prop.h"
#include "tasks/common/action_cost.h"
#include "tasks/common/constant_binder.h"
#include "tasks/common/layout.h"
#include "tasks/common/press_button.h"
#include "tasks/common/random_variables.h"
#include "tasks/family.h"
#include "tasks/gather_and_recall/reward.h"

namespace engram::tasks {

struct GatherParams {
  TaskSpec task;
  int N_CUBES;
  StepRange FLASH_DURATION_STEPS{8, 14};
  double DISC_RADIUS = 0.12;     // m
  double DISC_ON_THRESH = 0.10;  // m from the disc's centre
  SmoothnessParams smoothness = kGatherSmoothness;

  void declare(ConstantBinder& constants);
  // Throws Error unless the disc has room for the cubes, and the episode time.
  void check(int horizon) const;
};

inline constexpr std::array<GatherParams, 5> kGatherVariants = {{
    {{"GatherAndRecall1-VLA-v0", 200, Split::kShort}, 1},
    {{"GatherAndRecall3-VLA-v0", 400, Split::kMedium}, 3},
    {{"GatherAndRecall5-VLA-v0", 600, Split::kMedium}, 5},
    {{"GatherAndRecall7-VLA-v0", 800, Split::kLong}, 7},
    {{"GatherAndRecall9-VLA-v0", 1000, Split::kLong}, 9},
}};

inline constexpr int kMaxCubes = 9;
inline constexpr int kColors = 3;
inline constexpr std::array<mjcf::Rgba, kColors> FLASH_COLORS = {
    {{1, 0, 0, 1}, {0, 1, 0, 1}, {0, 0, 1, 1}}};
inline constexpr double CUBE_HALF_SIZE = 0.02;                 // m
inline constexpr double DISC_HALF_HEIGHT = 0.003;              // m
inline constexpr double BUTTON_SPACING = 0.14;                 // m
inline constexpr double BUTTON_X_OFFSET_FROM_DISC = -0.22;     // m
inline constexpr double DISC_X_MIN = 0.00, DISC_X_MAX = 0.08;  // m
inline constexpr double DISC_Y_MIN = 0.10, DISC_Y_MAX = 0.18;  // m
inline constexpr double LAMP_X_OFFSET_FROM_DISC = 0.24;        // m
inline constexpr double LAMP_Y_OFFSET_FROM_DISC = 0.06;        // m
inline constexpr double GRASP_THRESH = 0.05;                   // m
inline constexpr double kJitter = 0.005;                       // m
inline constexpr double kPlaceMargin = 0.011;  // m: how far from its place a cube may come to rest
inline constexpr double kOnDisc =
    2 * DISC_HALF_HEIGHT + CUBE_HALF_SIZE;  // m: height of a placed cube
inline constexpr mjcf::Rgba kDiscColor = {160 / 255.0, 160 / 255.0, 170 / 255.0, 1};
inline constexpr mjcf::Rgba kBulbOff = {245 / 255.0, 245 / 255.0, 245 / 255.0, 1};
inline constexpr double kFlashEmission = 1;

// Random variables of an episode.
struct GatherVariables {
  GatherVariables(RandomVariables list, const GatherParams& params);

  IntegerVariable flash_color;
  IntegerVariable trigger_count;  // cubes on the disc with which the flash begins
  IntegerVariable duration;
  RealVariable disc_x;
  RealVariable disc_y;
  VariableHandle cube_jitter;
};

// Parameters of the button of one colour.
PressButtonParams gather_button(int color);

// The largest number of placed cubes that may begin the flash.
int max_triggers(int cubes);

// Fills in TaskInfo, apart from what the registry knows, reward terms and state fields.
void describe_gather(TaskInfo& info);

// Place of a cube on the disc, from the disc's centre: a grid around the middle, the far end last.
// The fingers close along y, so the rows need more room.
Vec2 place_on_disc(int cube);

}  // namespace engram::tasks
