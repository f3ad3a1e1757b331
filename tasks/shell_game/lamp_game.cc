#include "tasks/shell_game/lamp_game.h"

namespace engram::tasks {
namespace {

template <class Setup>
Setup with_target_color(Setup setup) {
  setup.target = "target_color";
  setup.target_description = "colour of the lamp: 0 red, 1 green, 2 blue";
  return setup;
}

}  // namespace

ShellLampGame::ShellLampGame(const RegistryEntry& entry, Setup setup)
    : ShellTouchGame(entry, with_target_color(setup), false), cue_(scene_) {
  info_.hidden_draw = ShellLampCue::mapping_draw().name;
  info_.options = {ShellLampCue::fixed_mapping_option()};
  info_.constants.emplace_back("LAMP_BEHIND_OFFSET_X", LAMP_BEHIND_OFFSET_X);
  info_.constants.emplace_back("LAMP_HEIGHT", LAMP_HEIGHT);
  info_.state_fields = {
      {"obj_to_goal_pos", 3, DType::kFloat32, "m", "position of the target slot minus TCP"},
      {"target_color", 1, DType::kFloat32, "", "0 red, 1 green, 2 blue"},
      {"oracle_info", 1, DType::kFloat32, "", "slot of that colour's mug in the end"}};
}

void ShellLampGame::bind(const Bindings& bindings) {
  ShellTouchGame::bind(bindings);
  cue_.bind(bindings);
  // Told in info only: policies get the colour from the lamp.
  task_cue_ = bindings.outputs->add<float>("task_cue", 1, "", "colour of the lamp");
}

void ShellLampGame::reset_cue(const Episode& episode, int draw) const {
  const int env = episode.env();
  const bool fixed = engine_.options[0] != 0;
  const int mapping = fixed ? 0 : episode.integer(draw, 0, ShellLampCue::kMappingCount - 1);
  std::array<Eigen::Vector3d, kCups> slots;
  for (int slot = 0; slot < kCups; ++slot) {
    slots[static_cast<std::size_t>(slot)] = slot_pos(env, slot, BALL_RADIUS);
  }
  cue_.reset(env, mapping, slots);
}

void ShellLampGame::judge_slot(int env, int slot) const {
  engine_.oracle_info[env] = slot;
  task_cue_[env] = static_cast<float>(target_[env]);
  judge(env, mug_slot_pos(env, slot));
}

void ShellLampGame::observe(Range envs, FloatRows out) {
  for (int env = envs.begin; env < envs.end; ++env) {
    float* next = write_point(obj_to_goal(env), out.row(env));
    next[0] = static_cast<float>(target_[env]);
    next[1] = static_cast<float>(engine_.oracle_info[env]);
  }
}

}  // namespace engram::tasks
