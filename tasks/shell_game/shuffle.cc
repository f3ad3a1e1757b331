#include "tasks/shell_game/shuffle.h"

#include <array>

#include "tasks/shell_game/lamp_game.h"
#include "tasks/shell_game/swaps.h"
#include "tasks/shell_game/touch_game.h"

namespace engram::tasks {
namespace {

// --- parameters (shell 0.1) ---

struct Variant {
  StepRange CUE_PHASE_STEPS;
  StepRange SHUFFLE_PHASE_STEPS;
  StepRange NUM_SWAPS;
  bool frozen;
};
constexpr Variant kShort = {{1, 5}, {20, 35}, {2, 4}, true};
constexpr Variant kLong = {{10, 100}, {100, 400}, {5, 15}, false};
constexpr int kMaxSwaps = 15;

const Variant& variant_of(const RegistryEntry& entry) {
  return entry.split == Split::kShort ? kShort : kLong;
}

std::vector<std::pair<std::string, std::string>> shuffle_phases() {
  return {{"cue", "elapsed < cue_steps"},
          {"shuffle", "cue_steps <= elapsed < cue_steps + shuffle_steps"},
          {"manipulation", "elapsed >= cue_steps + shuffle_steps"}};
}

// A shell game of which the mugs swap places between cue and manipulation phase. They stand where
// they are put in every control step: in between, physics may move them, so that the robot feels
// what it meets, but it cannot carry anything away.
template <class Game>
class Shuffled : public Game {
 public:
  void bind(const Bindings& bindings) override {
    Game::bind(bindings);
    shuffle_.bind(*bindings.memory, variant_.NUM_SWAPS.high);
  }

  void reset(const Episode& episode) override {
    Game::reset(episode);
    const int env = episode.env();
    const auto draw = [&episode](int index, StepRange range) {
      return episode.integer(index, range.low, range.high);
    };
    const int steps = draw(kShuffleSteps, variant_.SHUFFLE_PHASE_STEPS);
    const int swaps = draw(kNumSwaps, variant_.NUM_SWAPS);
    shuffle_.reset(env, this->cue_end(env), steps, swaps, draw_pairs(episode));
    this->start_manipulation_at(env, shuffle_.end(env));
  }

 protected:
  enum OwnDraw { kShuffleSteps = Game::kFirstOwnDraw, kNumSwaps, kSwapPairList, kFirstDrawOfGame };

  template <class... Setup>
  Shuffled(const RegistryEntry& entry, const Variant& variant, const Setup&... setup)
      : Game(entry, setup...), variant_(variant) {
    TaskInfo& info = this->info_;
    info.termination = Termination::kNever;
    info.phases = shuffle_phases();
    const auto whole = [&info](const char* name, int width, StepRange range, const char* unit,
                               const char* what) {
      info.draws.push_back({name, width, true, static_cast<double>(range.low),
                            static_cast<double>(range.high), unit, what});
    };
    whole("shuffle_steps", 1, variant.SHUFFLE_PHASE_STEPS, "control steps",
          "length of the shuffle phase");
    whole("num_swaps", 1, variant.NUM_SWAPS, "", "swaps in the shuffle");
    whole("swap_pairs", variant.NUM_SWAPS.high, {0, 2}, "",
          "slots of each swap: 0 left and center, 1 left and right, 2 center and right");
    info.constants.emplace_back("NUM_SWAPS", variant.NUM_SWAPS.constant());
    info.constants.emplace_back("SHUFFLE_PHASE_STEPS", variant.SHUFFLE_PHASE_STEPS.constant());
    info.constants.emplace_back("SWAP_ARC_HEIGHT", SWAP_ARC_HEIGHT);
  }

  bool shuffle_begins(int env) const {
    return this->engine_.state->elapsed[env] == shuffle_.begin(env);
  }

  // Mugs, in the phase of this step.
  void move_mugs(int env) const {
    const int elapsed = this->engine_.state->elapsed[env];
    if (elapsed < shuffle_.begin(env)) return;
    for (int mug = 0; mug < kCups; ++mug) {
      const Eigen::Vector3d center = this->mug_slot_pos(env, 1);
      if (shuffle_.is_running(env, elapsed)) {
        this->stand_mug(env, mug, center + shuffle_.offset(env, mug, elapsed));
      } else {
        this->stand_mug(env, mug, shuffle_.final_slot(env, mug));
      }
    }
  }

  Shuffle shuffle_;

 private:
  std::array<int, kMaxSwaps> draw_pairs(const Episode& episode) const {
    std::array<int, kMaxSwaps> pairs{};
    const double* pinned = episode.pinned(kSwapPairList);
    RandomStream random = episode.stream(kSwapPairList);
    for (int i = 0; i < variant_.NUM_SWAPS.high; ++i) {
      pairs[static_cast<std::size_t>(i)] =
          pinned != nullptr ? static_cast<int>(pinned[i]) : random.integer(0, 2);
    }
    return pairs;
  }

  Variant variant_;
};

class ShellGameShuffleTouch final : public Shuffled<ShellTouchGame> {
 public:
  ShellGameShuffleTouch(const RegistryEntry& entry, const Variant& variant)
      : Shuffled(entry, variant,
                 Setup{.CUE_PHASE_STEPS = variant.CUE_PHASE_STEPS,
                       .target = "cup_with_ball_number",
                       .target_description = "first slot of the mug that hides the ball",
                       .frozen = variant.frozen},
                 true),
        ball_(add_red_ball()) {
    for (const char* unused : {"ACTION_L2_COEF", "ACTION_DELTA_L2_COEF", "QVEL_L2_COEF"}) {
      info_.constants.emplace_back(unused, 0.0);
    }
    info_.state_fields = {
        {"obj_pose", 7, DType::kFloat32, "m", "of the mug over the ball"},
        {"ball_pose", 7, DType::kFloat32, "m", "of the red ball"},
        {"oracle_info", 1, DType::kFloat32, "", "slot of the ball after the shuffle"}};
  }

  void advance(Range envs) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      move_mugs(env);
      move_ball(env);
    }
  }

  // The mugs never are where somebody has shoved them, so that there is no displacement.
  void evaluate(Range envs) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      engine_.oracle_info[env] = shuffle_.final_slot(env, target_[env]);
      judge(env, mug_pos(env, target_[env]));
    }
  }

  void observe(Range envs, FloatRows out) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      float* next = write_pose(env, target_[env], out.row(env));
      next = write_pose(env, ball_, next);
      *next = static_cast<float>(engine_.oracle_info[env]);
    }
  }

 private:
  void move_ball(int env) const {
    const int start = target_[env];
    if (engine_.state->elapsed[env] == 0)
      place_sphere(env, ball_, slot_pos(env, start, BALL_RADIUS));
    if (shuffle_begins(env)) {
      const Eigen::Vector3d parked = slot_pos(env, start, BALL_RADIUS + HEIGHT_OFFSET);
      engine_.state->hide_prop(env, ball_, parked.data());
    }
    if (manipulation_begins(env)) {
      place_sphere(env, ball_, slot_pos(env, shuffle_.final_slot(env, start), BALL_RADIUS));
    }
  }

  int ball_;
};

class ShellGameShuffleColorLamp final : public Shuffled<ShellLampGame> {
 public:
  ShellGameShuffleColorLamp(const RegistryEntry& entry, const Variant& variant)
      : Shuffled(entry, variant,
                 Setup{.CUE_PHASE_STEPS = variant.CUE_PHASE_STEPS, .frozen = variant.frozen}) {
    info_.draws.push_back(ShellLampCue::mapping_draw());
    info_.constants.emplace_back("LAMP_RADIUS", 0.018);  // unused
    info_.constants.emplace_back(
        "COLOR_RGBA",
        ConstantList{ConstantList{1, 0, 0, 1}, ConstantList{0, 1, 0, 1}, ConstantList{0, 0, 1, 1}});
  }

  void reset(const Episode& episode) override {
    Shuffled::reset(episode);
    reset_cue(episode, kFirstDrawOfGame);
  }

  void advance(Range envs) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      move_mugs(env);
      if (shuffle_begins(env)) cue_.hide_balls(env);
      if (manipulation_begins(env)) cue_.show_color(env, target_[env]);
    }
  }

  void evaluate(Range envs) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      judge_slot(env, shuffle_.final_slot(env, target_mug(env)));
    }
  }
};

}  // namespace

std::unique_ptr<Task> make_shell_game_shuffle_touch(const RegistryEntry& entry) {
  return std::make_unique<ShellGameShuffleTouch>(entry, variant_of(entry));
}

std::unique_ptr<Task> make_shell_game_shuffle_color_lamp(const RegistryEntry& entry) {
  return std::make_unique<ShellGameShuffleColorLamp>(entry, variant_of(entry));
}

}  // namespace engram::tasks
