#include "tasks/gather_and_recall/params.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "core/base/error.h"
#include "tasks/common/colors.h"
#include "tasks/common/lamp.h"
#include "tasks/common/phase_budget.h"

namespace engram::tasks {
namespace {

constexpr int kTimePerCube = 75;  // control steps
constexpr int kTimeToPress = 25;

ConstantList published_colors() {
  ConstantList colors;
  for (const mjcf::Rgba& rgba : FLASH_COLORS) colors.push_back(published_color(rgba));
  return colors;
}

}  // namespace

void GatherParams::declare(ConstantBinder& constants) {
  constants.integer("N_CUBES", N_CUBES, {1, kMaxCubes}, "", "cubes to be gathered");
  constants.fixed({{"CUBE_HALF_SIZE", CUBE_HALF_SIZE}, {"DISC_HALF_HEIGHT", DISC_HALF_HEIGHT}});
  constants.steps("FLASH_DURATION_STEPS", FLASH_DURATION_STEPS, kPhaseSteps,
                  "how long the lamp shows the colour", {"flash_duration", "length of the flash"});
  constants.real("DISC_RADIUS", DISC_RADIUS, {0.04, 0.16}, "m",
                 "of the disc; buttons and lamp stand 0.22 and 0.24 m from its centre");
  constants.real("DISC_ON_THRESH", DISC_ON_THRESH, {0.015, 0.2}, "m",
                 "how near the disc's centre a cube counts as on it");
  constants.fixed({{"FLASH_COLORS", published_colors()},
                   {"CUBE_COLORS", published_colors()},
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
                   {"LAMP_Y_OFFSET_FROM_DISC", LAMP_Y_OFFSET_FROM_DISC}});
  declare_lamp(constants);
  constants.fixed({{"GRASP_THRESH", GRASP_THRESH},
                   {"CUBE_VEL_THRESH", CUBE_VEL_THRESH},
                   {"HEIGHT_OFFSET", 1000.0},
                   {"SUCCESS_BONUS", kGatherSuccessReward},
                   {"FAILURE_PENALTY", FAILURE_PENALTY}});
  smoothness.declare(constants);
  constants.fixed([&] { gather_button(0).declare(constants); });
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
  check_horizon(horizon, {{"N_CUBES x 75 to gather", N_CUBES * kTimePerCube}}, kTimeToPress);
}

Vec2 place_on_disc(int cube) {
  static constexpr std::array<std::array<int, 2>, kMaxCubes> kOrder = {
      {{0, 0}, {-1, 0}, {1, 0}, {-1, -1}, {0, -1}, {-1, 1}, {0, 1}, {1, -1}, {1, 1}}};
  constexpr double kPitchX = 0.052;  // m
  constexpr double kPitchY = 0.066;  // m
  const auto& [column, row] = kOrder[at(cube)];
  return {column * kPitchX, row * kPitchY};
}

PressButtonParams gather_button(int color) {
  PressButtonParams params;
  params.shape.BUTTON_BASE_HALF_SIZE = {0.04, 0.04, 0.015};
  params.shape.BUTTON_CAP_RADIUS = 0.025;
  params.shape.cap_rgba = FLASH_COLORS[at(color)];
  params.BUTTON_PRESS_XY_RADIUS = 0.04;
  params.publishes_release = false;
  return params;
}

int max_triggers(int cubes) { return std::max(1, cubes - 1); }

GatherVariables::GatherVariables(RandomVariables list, const GatherParams& params)
    : flash_color(list.integer("flash_color", {0, kColors - 1}, "",
                               "colour of the flash and of the right button")),
      trigger_count(list.integer("flash_trigger_count", {1, max_triggers(params.N_CUBES)}, "",
                                 "cubes on the disc with which the flash begins")),
      duration(list.of(params.FLASH_DURATION_STEPS)),
      disc_x(list.real("disc_x", {DISC_X_MIN, DISC_X_MAX}, "m", "centre of the disc")),
      disc_y(list.real("disc_y", {DISC_Y_MIN, DISC_Y_MAX}, "m", "centre of the disc")),
      cube_jitter(list.add({"cube_jitter", 2 * params.N_CUBES, false, -kJitter, kJitter, "m",
                            "x, y of every cube, from its place in the cluster"})) {}

void describe_gather(TaskInfo& info) {
  info.candidates = kColors;
  info.answer =
      "the first button that is pressed while all cubes rest on the disc; its place in the order "
      "red, green, blue, from 0";
  info.termination = Termination::kSuccessOrFailed;
  info.success_reward = kGatherSuccessReward;
  info.oracle_dim = 1;
  info.hidden_variable = "flash_color";
  info.phases = {{"move", "not all cubes rest on the disc"},
                 {"flash", "flash_duration steps from the step with flash_trigger_count cubes"},
                 {"press", "all cubes rest on the disc"}};
}

}  // namespace engram::tasks
