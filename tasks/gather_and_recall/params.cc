#include "tasks/gather_and_recall/params.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "core/base/error.h"
#include "tasks/common/colors.h"
#include "tasks/common/lamp.h"
#include "tasks/common/task_info.h"

namespace engram::tasks {
namespace {

constexpr int kTimePerCube = 75;  // control steps
constexpr int kTimeToPress = 25;

std::vector<RandomVariable> draws(const GatherParams& params) {
  const int cubes = params.N_CUBES;
  return {
      {"flash_color", 1, true, 0, kColors - 1.0, "", "colour of the flash and of the right button"},
      {"flash_trigger_count", 1, true, 1, static_cast<double>(most_triggers(cubes)), "",
       "cubes on the disc with which the flash begins"},
      params.FLASH_DURATION_STEPS.draw("flash_duration", "length of the flash",
                                       "FLASH_DURATION_STEPS"),
      {"disc_x", 1, false, DISC_X_MIN, DISC_X_MAX, "m", "centre of the disc"},
      {"disc_y", 1, false, DISC_Y_MIN, DISC_Y_MAX, "m", "centre of the disc"},
      {"cube_jitter", 2 * cubes, false, -kJitter, kJitter, "m",
       "x, y of every cube, from its place in the cluster"},
  };
}

ConstantTable constants(const GatherParams& params) {
  ConstantList colors;
  for (const mjcf::Rgba& rgba : FLASH_COLORS) colors.push_back(published_color(rgba));
  ConstantTable table = {
      {"N_CUBES", params.N_CUBES},
      {"CUBE_HALF_SIZE", CUBE_HALF_SIZE},
      {"DISC_RADIUS", params.DISC_RADIUS},
      {"DISC_HALF_HEIGHT", DISC_HALF_HEIGHT},
      {"DISC_ON_THRESH", params.DISC_ON_THRESH},
      {"FLASH_DURATION_STEPS", params.FLASH_DURATION_STEPS.constant()},
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
  add_constants(params.smoothness, table);
  add_press_constants(gather_button(0), table);
  return table;
}

}  // namespace

void GatherParams::constants(Changes& list) {
  list.integer("N_CUBES", N_CUBES, {1, kMaxCubes}, "", "cubes to be gathered");
  list.steps("FLASH_DURATION_STEPS", FLASH_DURATION_STEPS, kPhaseSteps,
             "how long the lamp shows the colour");
  list.real("DISC_RADIUS", DISC_RADIUS, {0.04, 0.16}, "m",
            "of the disc; buttons and lamp stand 0.22 and 0.24 m from its centre");
  list.real("DISC_ON_THRESH", DISC_ON_THRESH, {0.015, 0.2}, "m",
            "how near the disc's centre a cube counts as on it");
  smoothness.constants(list);
}

void GatherParams::check(int horizon) const {
  double distance = 0;  // of the outermost cube's centre
  double extent = 0;    // of its outermost side
  for (int cube = 0; cube < N_CUBES; ++cube) {
    const Vec2 place = place_on_disc(cube);
    distance = std::max(distance, place.norm());
    extent = std::max(extent, place.cwiseAbs().maxCoeff() + CUBE_HALF_SIZE);
  }
  const std::string cubes = std::to_string(N_CUBES) + (N_CUBES == 1 ? " cube" : " cubes");
  if (distance + kPlaceMargin > DISC_ON_THRESH) {
    throw Error(Error::kInvalidArgument, cubes + " do not stand apart within DISC_ON_THRESH " +
                                             in_millimetres(DISC_ON_THRESH) +
                                             ": the outermost is " + in_millimetres(distance) +
                                             " + " + in_millimetres(kPlaceMargin) +
                                             " from the disc's centre");
  }
  if (extent > DISC_RADIUS) {
    throw Error(Error::kInvalidArgument, cubes + " reach " + in_millimetres(extent) +
                                             " from the disc's centre, beyond DISC_RADIUS " +
                                             in_millimetres(DISC_RADIUS));
  }
  check_time(horizon, {{"N_CUBES x 75 to gather", N_CUBES * kTimePerCube}}, kTimeToPress);
}

Vec2 place_on_disc(int cube) {
  static constexpr std::array<std::array<int, 2>, kMaxCubes> kOrder = {
      {{0, 0}, {-1, 0}, {1, 0}, {-1, -1}, {0, -1}, {-1, 1}, {0, 1}, {1, -1}, {1, 1}}};
  constexpr double kPitchX = 0.052;  // m
  constexpr double kPitchY = 0.066;  // m
  const auto& [column, row] = kOrder[static_cast<std::size_t>(cube)];
  return {column * kPitchX, row * kPitchY};
}

PressButtonParams gather_button(int color) {
  PressButtonParams params;
  params.shape.BUTTON_BASE_HALF_SIZE = {0.04, 0.04, 0.015};
  params.shape.BUTTON_CAP_RADIUS = 0.025;
  params.shape.cap_rgba = FLASH_COLORS[static_cast<std::size_t>(color)];
  params.BUTTON_PRESS_XY_RADIUS = 0.04;
  return params;
}

int most_triggers(int cubes) { return std::max(1, cubes - 1); }

void describe_gather(const GatherParams& params, TaskInfo& info) {
  info.candidates = kColors;
  info.answer =
      "the first button that is pressed while all cubes rest on the disc; its place in the order "
      "red, green, blue, from 0";
  info.termination = Termination::kSuccessOrFailed;
  info.success_reward = kGatherSuccessReward;
  info.oracle_dim = 1;
  info.random_variables = draws(params);
  info.hidden_variable = "flash_color";
  info.constants = constants(params);
  info.phases = {{"move", "not all cubes rest on the disc"},
                 {"flash", "flash_duration steps from the step with flash_trigger_count cubes"},
                 {"press", "all cubes rest on the disc"}};
}

}  // namespace engram::tasks
