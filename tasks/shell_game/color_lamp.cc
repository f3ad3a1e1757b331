#include "tasks/shell_game/color_lamp.h"

#include "tasks/shell_game/lamp_game.h"

namespace engram::tasks {
namespace {

class ShellGameColorLamp final : public ShellLampGame {
 public:
  explicit ShellGameColorLamp(const RegistryEntry& entry) : ShellLampGame(entry, {}) {
    info_.termination = Termination::kNever;
    info_.phases = cue_manipulation_phases();
    info_.draws.push_back(ShellLampCue::mapping_draw());
  }

  void reset(const Episode& episode) override {
    ShellLampGame::reset(episode);
    reset_cue(episode, kMapping);
  }

  void advance(Range envs) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      if (manipulation_begins(env)) {
        cue_.hide_balls(env);
        cue_.show_color(env, target_[env]);
      }
      if (!is_manipulation(env)) continue;
      for (int mug = 0; mug < kCups; ++mug) stand_mug(env, mug, mug);
    }
  }

  void evaluate(Range envs) override {
    for (int env = envs.begin; env < envs.end; ++env) judge_slot(env, target_mug(env));
  }

 private:
  enum OwnDraw { kMapping = kFirstOwnDraw };
};

}  // namespace

std::unique_ptr<Task> make_shell_game_color_lamp(const RegistryEntry& entry) {
  return std::make_unique<ShellGameColorLamp>(entry);
}

}  // namespace engram::tasks
