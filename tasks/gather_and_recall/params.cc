#include "tasks/gather_and_recall/params.h"

#include <algorithm>
#include <string>

#include "tasks/gather_and_recall/rules.h"
#include "tasks/parts/colors.h"
#include "tasks/parts/variant.h"

namespace engram::tasks {
namespace {

struct Params {
  std::string_view id;
  int N_CUBES;
};

constexpr std::array<Params, 5> kVariants = {{
    {"GatherAndRecall1-VLA-v0", 1},
    {"GatherAndRecall3-VLA-v0", 3},
    {"GatherAndRecall5-VLA-v0", 5},
    {"GatherAndRecall7-VLA-v0", 7},
    {"GatherAndRecall9-VLA-v0", 9},
}};

std::vector<Draw> draws(int cubes) {
  return {
      {"flash_color", 1, true, 0, kColors - 1.0, "", "colour of the flash and of the right button"},
      {"flash_trigger_count", 1, true, 1, static_cast<double>(most_triggers(cubes)), "",
       "cubes on the disc with which the flash begins"},
      {"flash_duration", 1, true, static_cast<double>(FLASH_DURATION_STEPS.low),
       static_cast<double>(FLASH_DURATION_STEPS.high), "control steps", "length of the flash"},
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
      {"LAMP_BASE_RADIUS", 0.018},
      {"LAMP_BASE_HALF_HEIGHT", 0.008},
      {"LAMP_STEM_RADIUS", 0.004},
      {"LAMP_STEM_HALF_HEIGHT", 0.020},
      {"LAMP_BULB_RADIUS", 0.012},
      {"GRASP_THRESH", GRASP_THRESH},
      {"CUBE_VEL_THRESH", CUBE_VEL_THRESH},
      {"HEIGHT_OFFSET", 1000.0},
      {"SUCCESS_BONUS", kGatherSuccessReward},
      {"FAILURE_PENALTY", FAILURE_PENALTY},
      {"ACTION_L2_COEF", kGatherSmoothness.ACTION_L2_COEF},
      {"ACTION_DELTA_L2_COEF", kGatherSmoothness.ACTION_DELTA_L2_COEF},
      {"QVEL_L2_COEF", kGatherSmoothness.QVEL_L2_COEF},
  };
  add_press_constants(gather_button(0), table);
  return table;
}

std::vector<std::string> reward_terms() {
  return {"reaching_reward", "place_progress", "n_on_disc",       "button_press_reward",
          "smooth_penalty",  "action_l2",      "delta_action_l2", "qvel_l2"};
}

std::vector<Field> state_fields(int cubes) {
  std::vector<Field> fields = {
      {"obj_to_goal_pos", 3, DType::kFloat32, "m", "next goal minus TCP position"},
      {"oracle_info", 1, DType::kFloat32, "", "colour of the flash"},
      {"disc_pose", 7, DType::kFloat32, "m", ""},
      {"cubes_on_disc", cubes, DType::kFloat32, "", "has been on the disc"},
      {"n_on_disc", 1, DType::kFloat32, "", "cubes that have been on the disc"},
      {"all_on_disc", 1, DType::kFloat32, "", "all of them are, and rest"},
      {"flash_active", 1, DType::kFloat32, "", ""},
      {"flash_color", 1, DType::kFloat32, "", ""},
      {"pressed_button", 1, DType::kFloat32, "", "-1: none"}};
  for (int cube = 0; cube < cubes; ++cube) {
    fields.push_back({"cube_" + std::to_string(cube) + "_pose", 7, DType::kFloat32, "m", ""});
  }
  return fields;
}

}  // namespace

int gather_cubes(std::string_view id) { return find_variant(kVariants, id).N_CUBES; }

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
  info.reward_terms = reward_terms();
  info.phases = {{"move", "not all cubes rest on the disc"},
                 {"flash", "flash_duration steps from the step with flash_trigger_count cubes"},
                 {"press", "all cubes rest on the disc"}};
  info.state_fields = state_fields(cubes);
}

}  // namespace engram::tasks
