#include "tasks/shell_game/touch.h"

#include <algorithm>

#include "tasks/shell_game/touch_game.h"

namespace engram::tasks {
namespace {

class ShellGameTouch final : public ShellTouchGame {
 public:
  explicit ShellGameTouch(const RegistryEntry& entry)
      : ShellTouchGame(entry,
                       {.target = "cup_with_ball_number",
                        .target_description = "slot of the mug that hides the ball"},
                       true),
        ball_(add_red_ball()) {
    info_.termination = Termination::kSuccess;
    info_.phases = cue_manipulation_phases();
    info_.state_fields = {{"obj_pose", 7, DType::kFloat32, "m", "of the mug over the ball"},
                          {"ball_pose", 7, DType::kFloat32, "m", "of the red ball"},
                          {"oracle_info", 1, DType::kFloat32, "", "slot of the ball"}};
  }

  void bind(const Bindings& bindings) override {
    ShellTouchGame::bind(bindings);
    reference_ = bindings.memory->add<double>("mug_reference", 2 * kCups, "m");
  }

  void advance(Range envs) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      play_free_mugs(env, ball_);
      if (manipulation_begins(env)) remember_mugs(env);
    }
  }

  void evaluate(Range envs) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      engine_.oracle_info[env] = target_[env];
      judge(env, mug_pos(env, target_[env]), max_displacement(env));
    }
  }

  void observe(Range envs, FloatRows out) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      float* next = write_pose(env, target_[env], out.row(env));
      next = write_pose(env, ball_, next);
      *next = static_cast<float>(target_[env]);
    }
  }

 private:
  // Where the mugs stand before anybody could shove them.
  void remember_mugs(int env) const {
    for (int mug = 0; mug < kCups; ++mug) {
      std::copy_n(engine_.state->prop_pos_of(env, mug), 2, reference_.row(env) + 2 * mug);
    }
  }

  double max_displacement(int env) const {
    if (!is_manipulation(env)) return 0;
    double farthest = 0;
    for (int mug = 0; mug < kCups; ++mug) {
      const Eigen::Map<const Eigen::Vector2d> before(reference_.row(env) + 2 * mug);
      farthest = std::max(farthest, (mug_pos(env, mug).head<2>() - before).norm());
    }
    return farthest;
  }

  int ball_;
  Column<double> reference_;  // (kCups * 2) m
};

}  // namespace

std::unique_ptr<Task> make_shell_game_touch(const RegistryEntry& entry) {
  return std::make_unique<ShellGameTouch>(entry);
}

}  // namespace engram::tasks
