#include "tasks/gather_and_recall/params.h"

#include <algorithm>

#include "tasks/gather_and_recall/rules.h"
#include "tasks/parts/colors.h"
#include "tasks/parts/lamp.h"
#include "tasks/parts/task_info.h"

namespace engram::tasks {
namespace {

std::vector<Draw> draws(int cubes) {
  return {
      {"flash_color", 1, true, 0, kColors - 1.0, "", "colour of the flash and of the right button"},
      {"flash_trigger_count", 1, true, 1, static_cast<double>(most_triggers(cubes)), "",
       "cubes on the disc with which the flash begins"},
      FLASH_DURATION_STEPS.draw("flash_duration", "length of the flash"),
      {"disc_x", 1, false, DISC_X_MIN, DISC_X_MAX, "m", "centre of the disc"},
      {"disc_y", 1, false, DISC_Y_MIN, DISC_Y_MAX, "m", "centre of the disc"},
      {"cube_jitter", 2 * cubes, false, -kJitter, kJitter, "m",
       "x, y of every cube, from its place in the cluster"},
  };
}

ConstantTable constants(int cubes) {
  ConstantList colors;
  for (const mjcf::Rgba& rgba : FLASH_COLORS) colors.push_back(published_color(rgba));
  ConstantTable table = {
      {"N_CUBES", cubes},
      {"CUBE_HALF_SIZE", CUBE_HALF_SIZE},
      {"DISC_RADIUS", DISC_RADIUS},
      {"DISC_HALF_HEIGHT", DISC_HALF_HEIGHT},
      {"DISC_ON_THRESH", DISC_ON_THRESH},
      {"FLASH_DURATION_STEPS", FLASH_DURATION_STEPS.constant()},
      {"FLASH_COLORS", colors},
      {"CUBE_COLORS", colors},
      {"BUTTON_SPACING", BUTTON_SPACING},
      {"DISC_X_MIN", DISC_X_MIN},
      {"DISC_X_MAX", DISC_X_MAX},
      {"DISC_Y_MIN", DISC_Y_MIN},
      {"DISC_Y_MAX", DISC_Y_MAX},
      {"BUTTON_X_OFFSET_FROM_DISC", BUTTON_X_OFFSET_FROM_DISC},
      {"CUBE_CLUSTER_X_OFFSET", CUBE_CLUSTER_X_OFFSET},
      {"CUBE_CLUSTER_CENTER_Y", CUBE_CLUSTER_CENTER_Y},
      {"CUBE_CLUSTER_SPACING_SCALE", CUBE_CLUSTER_SPACING_SCALE},
      {"LAMP_X_OFFSET_FROM_DISC", LAMP_X_OFFSET_FROM_DISC},
      {"LAMP_Y_OFFSET_FROM_DISC", LAMP_Y_OFFSET_FROM_DISC},
  };
  add_lamp_constants(table);
  append(table, {{"GRASP_THRESH", GRASP_THRESH},
                 {"CUBE_VEL_THRESH", CUBE_VEL_THRESH},
                 {"HEIGHT_OFFSET", 1000.0},
                 {"SUCCESS_BONUS", kGatherSuccessReward},
                 {"FAILURE_PENALTY", FAILURE_PENALTY}});
  add_constants(kGatherSmoothness, table);
  add_press_constants(gather_button(0), table);
  return table;
}

}  // namespace

PressButtonParams gather_button(int color) {
  PressButtonParams params;
  params.shape.BUTTON_BASE_HALF_SIZE = {0.04, 0.04, 0.015};
  params.shape.BUTTON_CAP_RADIUS = 0.025;
  params.shape.cap_rgba = FLASH_COLORS[static_cast<std::size_t>(color)];
  params.BUTTON_PRESS_XY_RADIUS = 0.04;
  return params;
}

int most_triggers(int cubes) { return std::max(1, cubes - 1); }

void describe_gather(int cubes, TaskInfo& info) {
  info.candidates = kColors;
  info.termination = Termination::kSuccessOrFailed;
  info.success_reward = kGatherSuccessReward;
  info.oracle_dim = 1;
  info.draws = draws(cubes);
  info.hidden_draw = "flash_color";
  info.constants = constants(cubes);
  info.phases = {{"move", "not all cubes rest on the disc"},
                 {"flash", "flash_duration steps from the step with flash_trigger_count cubes"},
                 {"press", "all cubes rest on the disc"}};
}

}  // namespace engram::tasks
