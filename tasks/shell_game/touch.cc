#include "tasks/shell_game/touch.h"

#include <algorithm>

#include "tasks/common/variant.h"
#include "tasks/shell_game/annotator.h"
#include "tasks/shell_game/touch_expert.h"
#include "tasks/shell_game/touch_rule.h"

namespace engram::tasks {
namespace {

constexpr double kMovedMug = 0.01;  // m: a mug moved further is an answer

// The RL task does not limit how far mugs are shoved.
struct ShovingParams : TouchParams {
  void declare(ConstantBinder& constants) {
    TouchParams::declare(constants);
    if (!task.is_rl()) TouchRule::declare(constants);
  }
};

class Touch final : public ShellGame {
 public:
  Touch(const RegistryEntry& entry, const ShovingParams& params)
      : ShellGame(entry, params, {}),
        rule_(params, {.shoving = !params.task.is_rl(), .placed_term = TouchRule::kPlacedInfo}),
        ball_(add_red_ball()),
        expert_(*this, params, params.CUE_PHASE_STEPS.high),
        annotator_({.game = *this, .ball = ball_}) {
    info_.termination = Termination::kSuccess;
    info_.phases = cue_manipulation_phases();
    rule_.describe(info_);
    info_.answer =
        "the first cup within GOAL_THRESH of which the robot rests in the manipulation phase, the "
        "nearest one if there are several, or that is moved by more than 1 cm; its slot";
    declare_state(*this);
  }

  void bind(const Bindings& bindings) override {
    ShellGame::bind(bindings);
    rule_.bind(bindings);
    reference_ = bindings.memory->add<double>("mug_reference", 2 * kCups, "m");
  }

  // --- phases ---

  void advance(Range envs) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      update_free_mugs(env, ball_);
      if (manipulation_begins(env)) remember_mugs(env);
    }
  }

  // --- success, reward ---

  void evaluate(Range envs) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      const int cup = target_[env];
      engine_.oracle_info[env] = cup;
      set_outcome(env, rule_.judge(*this, env, mugs_.pos(env, cup), max_displacement(env)));
      // A mug that is shoved or tilted may show what is under it.
      const int touched = rule_.touched_mug(*this, env);
      note_answer(env, touched >= 0 ? touched : moved_mug(env, kMovedMug));
    }
  }

  void dense_reward(Range envs, FloatRows out) override { rule_.dense_reward(*this, envs, out); }

  // --- observation ---

  void observe(Range envs, FloatRows out) override { write_state(*this, envs, out); }

  template <class Visitor>
  void state_row(Visitor& row, int env) const {
    row.field("obj_pose", 7, "m", "of the mug over the ball",
              [&] { return prop_pose(env, target_[env]); });
    row.field("ball_pose", 7, "m", "of the red ball", [&] { return prop_pose(env, ball_); });
    row.field("oracle_info", 1, "", "slot of the ball", [&] { return target_[env]; });
  }

  // --- expert ---

  const Expert& expert() const override { return expert_; }
  const Annotator* annotator() const override { return &annotator_; }

 private:
  // Notes the positions of the mugs before anybody could shove them.
  void remember_mugs(int env) const {
    for (int mug = 0; mug < kCups; ++mug) {
      std::copy_n(engine_.state->prop_pos_of(env, mug), 2, reference_.row(env) + 2 * mug);
    }
  }

  double max_displacement(int env) const {
    if (!rule_.is_shoving() || !is_manipulation(env)) return 0;
    double farthest = 0;
    for (int mug = 0; mug < kCups; ++mug) {
      const Eigen::Map<const Eigen::Vector2d> before(reference_.row(env) + 2 * mug);
      farthest = std::max(farthest, (mugs_.pos(env, mug).head<2>() - before).norm());
    }
    return farthest;
  }

  TouchRule rule_;
  int ball_;
  Column<double> reference_;  // (kCups * 2) m
  TouchExpert expert_;
  ShellGameAnnotator annotator_;
};

}  // namespace

constexpr std::array<ShovingParams, 2> kShovingVariants = {{
    {{{{"ShellGameTouch-VLA-v0", 30, Split::kShort}}}},
    {{{.task =
           {.id = "ShellGameTouch-v0", .horizon = 90, .split = Split::kRl, .memory_type = "Object"},
       .CUE_PHASE_STEPS = {5, 5},
       .MUG_SCALE = 1}}},
}};
constexpr auto kShovingRows = rows_of(kShovingVariants);

const Family kShellGameTouch = {
    .name = "ShellGameTouch",
    .memory_type = "Spatial",
    .instruction = "Observe which cup hides the ball, wait, then touch that cup.",
    .tasks = kShovingRows,
    .make = make_variant<Touch, kShovingVariants>,
    .expectations = {.min_reward = -0.0334, .max_reward = 1, .hides = true},
    .memory = {.irrelevant = CounterfactualChange::kDraw, .irrelevant_draw = "cue_steps"}};

}  // namespace engram::tasks
