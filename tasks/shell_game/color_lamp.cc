#include "tasks/shell_game/color_lamp.h"

#include "tasks/common/variant.h"
#include "tasks/shell_game/annotator.h"
#include "tasks/shell_game/lamp_cue.h"
#include "tasks/shell_game/touch_expert.h"
#include "tasks/shell_game/touch_rule.h"

namespace engram::tasks {
namespace {

struct ColorLampParams : TouchParams {
  void declare(ConstantBinder& constants) {
    TouchParams::declare(constants);
    LampCue::declare(constants);
  }
};

class ColorLamp final : public ShellGame {
 public:
  ColorLamp(const RegistryEntry& entry, const ColorLampParams& params)
      : ShellGame(entry, params,
                  {.target = LampCue::kTarget, .target_description = LampCue::kTargetDescription}),
        rule_(params, {}),
        cue_(scene_, params.BALL_RADIUS, RandomVariables(info_.random_variables)),
        expert_(*this, params, params.CUE_PHASE_STEPS.high),
        annotator_({.game = *this, .lamp = &cue_}) {
    info_.termination = Termination::kNever;
    info_.phases = cue_manipulation_phases();
    rule_.describe(info_);
    cue_.describe(info_);
    declare_state(*this);
  }

  void bind(const Bindings& bindings) override {
    ShellGame::bind(bindings);
    rule_.bind(bindings);
    cue_.bind(bindings);
    if (cue_.is_fixed()) reveal_answer();
  }

  // --- sampling ---

  void reset(const Episode& episode) override {
    ShellGame::reset(episode);
    cue_.reset(episode, mugs_);
  }

  // --- phases ---

  // The mugs are put back in every step, so that the robot cannot carry anything away.
  void advance(Range envs) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      if (manipulation_begins(env)) {
        cue_.hide_balls(env);
        cue_.show_color(env, target_[env]);
      }
      if (is_manipulation(env)) mugs_.stand_all(env);
    }
  }

  // --- success, reward ---

  void evaluate(Range envs) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      const int slot = cue_.mug_of(env, target_[env]);
      engine_.oracle_info[env] = slot;
      cue_.publish_color(env, target_[env]);
      set_outcome(env, rule_.judge(*this, env, mugs_.standing_pos(env, slot)));
      note_answer(env, rule_.touched_mug(*this, env));
    }
  }

  void dense_reward(Range envs, FloatRows out) override { rule_.dense_reward(*this, envs, out); }

  // --- observation ---

  void observe(Range envs, FloatRows out) override { write_state(*this, envs, out); }

  template <class Visitor>
  void state_row(Visitor& row, int env) const {
    LampCue::state_row(row, *this, env);
  }

  // --- expert ---

  const Expert& expert() const override { return expert_; }
  const Annotator* annotator() const override { return &annotator_; }

 private:
  TouchRule rule_;
  LampCue cue_;
  TouchExpert expert_;
  ShellGameAnnotator annotator_;
};

}  // namespace

constexpr std::array<ColorLampParams, 1> kVariants = {{
    {{{{"ShellGameColorLampTouch-VLA-v0", 30, Split::kShort}}}},
}};
constexpr auto kRows = rows_of(kVariants);

const Family kShellGameColorLampTouch = {
    .name = "ShellGameColorLampTouch",
    .memory_type = "Spatial",
    .instruction =
        "Observe which color is under each cup, then touch the cup matching the lamp color.",
    .tasks = kRows,
    .make = make_variant<ColorLamp, kVariants>,
    .expectations = {.min_reward = 0, .max_reward = 0.6667, .settles = false, .hides = true},
    .memory = {.irrelevant = CounterfactualChange::kSameAnswer}};

}  // namespace engram::tasks
