#include "tasks/shell_game/shuffle.h"

#include "tasks/common/action_cost.h"
#include "tasks/common/variant.h"
#include "tasks/shell_game/annotator.h"
#include "tasks/shell_game/lamp_cue.h"
#include "tasks/shell_game/shuffle_phase.h"
#include "tasks/shell_game/touch_expert.h"
#include "tasks/shell_game/touch_rule.h"

namespace engram::tasks {
namespace {

// --- parameters ---

constexpr ShuffleParams brief(const TaskSpec& task) {
  return {{{.task = task, .CUE_PHASE_STEPS = {1, 5}}}, {20, 35}, {2, 4}, true};
}
constexpr ShuffleParams lasting(const TaskSpec& task) {
  return {{{.task = task, .CUE_PHASE_STEPS = {10, 100}}}, {100, 400}, {5, 15}, false};
}

struct ShuffleTouchParams : ShuffleParams {
  SmoothnessParams smoothness = {};

  void declare(ConstantBinder& constants) {
    ShuffleParams::declare(constants);
    TouchRule::declare(constants);
    smoothness.declare(constants);
  }
};
struct ShuffleColorLampParams : ShuffleParams {
  void declare(ConstantBinder& constants) {
    ShuffleParams::declare(constants);
    LampCue::declare(constants);
    constants.fixed({{"LAMP_RADIUS", 0.018},  // unused
                     {"COLOR_RGBA", ConstantList{ConstantList{1, 0, 0, 1}, ConstantList{0, 1, 0, 1},
                                                 ConstantList{0, 0, 1, 1}}}});
  }
};

constexpr std::array<ShuffleTouchParams, 2> kTouchVariants = {{
    {lasting({"ShellGameShuffleTouch-Long-VLA-v0", 600, Split::kMedium})},
    {brief({"ShellGameShuffleTouch-VLA-v0", 60, Split::kShort})},
}};
constexpr std::array<ShuffleColorLampParams, 2> kColorLampVariants = {{
    {lasting({"ShellGameShuffleColorLampTouch-Long-VLA-v0", 600, Split::kMedium})},
    {brief({"ShellGameShuffleColorLampTouch-VLA-v0", 60, Split::kShort})},
}};

// A ball is under one of the mugs.
class ShuffleTouch final : public ShellGame {
 public:
  ShuffleTouch(const RegistryEntry& entry, const ShuffleTouchParams& params)
      : ShellGame(entry, params,
                  {.target_description = "first slot of the mug that hides the ball",
                   .frozen = params.frozen,
                   .shuffles = true}),
        rule_(params, {.shoving = true, .placed_term = TouchRule::kPlacedInfo}),
        shuffle_(params, RandomVariables(info_.random_variables)),
        smoothness_(params.smoothness),
        ball_(add_red_ball()),
        expert_(*this, params, params.latest_end()),
        annotator_({.game = *this, .ball = ball_, .shuffle = &shuffle_}) {
    info_.termination = Termination::kNever;
    rule_.describe(info_);
    shuffle_.describe(info_);
    declare_state(*this);
  }

  void bind(const Bindings& bindings) override {
    ShellGame::bind(bindings);
    rule_.bind(bindings);
    shuffle_.bind(bindings);
  }

  // --- sampling ---

  void reset(const Episode& episode) override {
    const int env = episode.env();
    ShellGame::reset(episode);
    shuffle_.reset(episode, cue_end(env));
    start_manipulation_at(env, shuffle_.end(env));
  }

  // --- phases ---

  void advance(Range envs) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      shuffle_.move(mugs_, env);
      move_ball(env);
    }
  }

  // --- success, reward ---

  // The mugs are never displaced by the robot.
  void evaluate(Range envs) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      const int cup = target_[env];
      engine_.oracle_info[env] = shuffle_.final_slot(env, cup);
      set_outcome(env, rule_.judge(*this, env, mugs_.pos(env, cup)));
      const int touched = rule_.touched_mug(*this, env);
      note_answer(env, touched < 0 ? -1 : shuffle_.final_slot(env, touched));
    }
  }

  void dense_reward(Range envs, FloatRows out) override {
    rule_.dense_reward(*this, envs, out);
    for (int env = envs.begin; env < envs.end; ++env) {
      if (!is_manipulation(env) || engine_.success[env] != 0) continue;
      *out.row(env) -= static_cast<float>(smoothness_penalty(engine_, env, smoothness_));
    }
  }

  // --- observation ---

  void observe(Range envs, FloatRows out) override { write_state(*this, envs, out); }

  template <class Visitor>
  void state_row(Visitor& row, int env) const {
    row.field("obj_pose", 7, "m", "of the mug over the ball",
              [&] { return prop_pose(env, target_[env]); });
    row.field("ball_pose", 7, "m", "of the red ball", [&] { return prop_pose(env, ball_); });
    row.field("oracle_info", 1, "", "slot of the ball after the shuffle",
              [&] { return answer(env); });
  }

  // --- expert ---

  const Expert& expert() const override { return expert_; }
  const Annotator* annotator() const override { return &annotator_; }

 private:
  double ball_radius() const { return params().BALL_RADIUS; }

  // It shows in its slot, hides during the shuffle, and then is under its mug.
  void move_ball(int env) const {
    const int start = target_[env];
    if (engine_.state->elapsed[env] == 0) {
      place_sphere(env, ball_, mugs_.slot_pos(env, start, ball_radius()));
    }
    if (shuffle_.begins(env)) {
      const Eigen::Vector3d parked = mugs_.slot_pos(env, start, ball_radius() + HEIGHT_OFFSET);
      engine_.state->hide_prop(env, ball_, parked.data());
    }
    if (manipulation_begins(env)) {
      const int end = shuffle_.final_slot(env, start);
      place_sphere(env, ball_, mugs_.slot_pos(env, end, ball_radius()));
    }
    cover_ball(env, ball_, start);
  }

  TouchRule rule_;
  ShufflePhase shuffle_;
  SmoothnessParams smoothness_;
  int ball_;
  TouchExpert expert_;
  ShellGameAnnotator annotator_;
};

// A ball of another colour is under every mug; a lamp names the colour after the shuffle.
class ShuffleColorLamp final : public ShellGame {
 public:
  ShuffleColorLamp(const RegistryEntry& entry, const ShuffleColorLampParams& params)
      : ShellGame(entry, params,
                  {.target = LampCue::kTarget,
                   .target_description = LampCue::kTargetDescription,
                   .frozen = params.frozen,
                   .shuffles = true}),
        rule_(params, {}),
        shuffle_(params, RandomVariables(info_.random_variables)),
        cue_(scene_, params.BALL_RADIUS, RandomVariables(info_.random_variables)),
        expert_(*this, params, params.latest_end()),
        annotator_({.game = *this, .lamp = &cue_, .shuffle = &shuffle_}) {
    info_.termination = Termination::kNever;
    rule_.describe(info_);
    cue_.describe(info_);
    shuffle_.describe(info_);
    declare_state(*this);
  }

  void bind(const Bindings& bindings) override {
    ShellGame::bind(bindings);
    rule_.bind(bindings);
    cue_.bind(bindings);
    shuffle_.bind(bindings);
  }

  // --- sampling ---

  void reset(const Episode& episode) override {
    const int env = episode.env();
    ShellGame::reset(episode);
    shuffle_.reset(episode, cue_end(env));
    start_manipulation_at(env, shuffle_.end(env));
    cue_.reset(episode, mugs_);
  }

  // --- phases ---

  void advance(Range envs) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      shuffle_.move(mugs_, env);
      if (shuffle_.begins(env)) cue_.hide_balls(env);
      if (manipulation_begins(env)) cue_.show_color(env, target_[env]);
    }
  }

  // --- success, reward ---

  void evaluate(Range envs) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      const int slot = shuffle_.final_slot(env, cue_.mug_of(env, target_[env]));
      engine_.oracle_info[env] = slot;
      cue_.publish_color(env, target_[env]);
      set_outcome(env, rule_.judge(*this, env, mugs_.standing_pos(env, slot)));
      const int touched = rule_.touched_mug(*this, env);
      note_answer(env, touched < 0 ? -1 : shuffle_.final_slot(env, touched));
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
  ShufflePhase shuffle_;
  LampCue cue_;
  TouchExpert expert_;
  ShellGameAnnotator annotator_;
};

}  // namespace

constexpr auto kTouchRows = rows_of(kTouchVariants);
constexpr auto kColorLampRows = rows_of(kColorLampVariants);

const Family kShellGameShuffleTouch = {
    .name = "ShellGameShuffleTouch",
    .memory_type = "Tracking",
    .instruction =
        "Observe which cup hides the ball, track the cups as they shuffle, then touch the "
        "correct cup.",
    .tasks = kTouchRows,
    .make = make_variant<ShuffleTouch, kTouchVariants>,
    .expectations = {.min_reward = 0, .max_reward = 0.6667, .settles = false, .hides = true},
    .memory = {.irrelevant = CounterfactualChange::kDraw,
               .irrelevant_draw = "cue_steps",
               .delay = "SHUFFLE_PHASE_STEPS",
               .items = "num_swaps"}};

const Family kShellGameShuffleColorLampTouch = {
    .name = "ShellGameShuffleColorLampTouch",
    .memory_type = "Tracking",
    .instruction =
        "Observe which color is under each cup, track the cups as they shuffle, then touch the "
        "cup matching the lamp color.",
    .tasks = kColorLampRows,
    .make = make_variant<ShuffleColorLamp, kColorLampVariants>,
    .expectations = {.min_reward = 0, .max_reward = 0.6667, .settles = false, .hides = true},
    .memory = {.irrelevant = CounterfactualChange::kSameAnswer,
               .delay = "SHUFFLE_PHASE_STEPS",
               .items = "num_swaps"}};

}  // namespace engram::tasks
