#include "tasks/colors/task.h"

#include "tasks/colors/annotator.h"
#include "tasks/colors/expert.h"
#include "tasks/colors/params.h"
#include "tasks/colors/touch_base.h"
#include "tasks/colors/touch_task.h"
#include "tasks/common/press_button.h"
#include "tasks/common/variant.h"

namespace engram::tasks {
namespace {

constexpr int kStabiliseSteps = 5;  // in which cubes are put back after they appear

// The VLA tasks: after the touches, a press of the button in the middle.
class ColorRecall final : public ColorTouchBase {
 public:
  ColorRecall(const RegistryEntry& entry, const ColorRecallParams& params)
      : ColorTouchBase(entry, params),
        button_(scene_, "center_button", params.button),
        expert_({.engine = engine_,
                 .info = info_,
                 .params = params_,
                 .rule = rule_,
                 .cubes = cubes_,
                 .clock = clock_,
                 .touch = touch_,
                 .sequence = sequence_,
                 .button = &button_,
                 .button_pressed = &button_pressed_}),
        annotator_(expert_) {
    info_.reward_terms = reward_terms_of(ColorReward{.touches = {.rule = params.rule}});
    declare_state(*this);
  }

  void bind(const Bindings& bindings) override {
    bind_touches(bindings);
    button_.bind(bindings);
    bind_sequence(bindings);
    displacement_ = bindings.memory->add<double>("displacement", 2, "m", "mean, largest");
    ColumnStore& info = *bindings.outputs;
    bind_info(info);
    strong_displacement_ = info.add<std::uint8_t>("strong_cube_displacement", 1, "",
                                                  "a cube is too far from where it appeared");
    max_displacement_ = info.add_privileged<float>("max_cube_displacement_xy", 1, "m");
    button_pressed_ = info.add<std::uint8_t>("button_pressed");
    button_pressable_ = info.add<std::uint8_t>("button_pressable");
    press_depth_ = info.add<float>("button_press_depth", 1, "m");
    distance_to_button_ = info.add<float>("xy_dist_to_button", 1, "m");
  }

  void reset(const Episode& episode) override {
    const int env = episode.env();
    begin_episode(episode);
    button_.reset(env, cubes_.button_center(env));
  }

  void advance(Range envs) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      show_phase(env, kStabiliseSteps);
      button_.follow_tool(env, is_acting(env));
    }
  }

  // --- success: touches, then the button ---

  void evaluate(Range envs) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      const bool acting = is_acting(env);
      const ColorCubes::Displacement moved = cubes_.displacement(env);
      displacement_.row(env)[0] = moved.mean;
      displacement_.row(env)[1] = moved.largest;
      const bool displaced = acting && moved.largest > MAX_ALLOWED_CUBE_DISPLACEMENT;
      const TouchTally tally = evaluate_touches(env);
      const bool pressable = tally.complete() && !displaced && acting;
      const PressEvents events = button_.press_and_lift(env, acting, pressable);
      button_pressed_[env] |= events.confirmed ? 1 : 0;
      const bool still = note_static(env);
      engine_.success[env] = pressable && button_pressed_[env] != 0 && still ? 1 : 0;

      button_pressable_[env] = pressable ? 1 : 0;
      strong_displacement_[env] = displaced ? 1 : 0;
      max_displacement_[env] = static_cast<float>(moved.largest);
      press_depth_[env] = static_cast<float>(button_.depth(env));
      distance_to_button_[env] = static_cast<float>(button_.distance(env));
      set_goal(env, goal(env, acting ? tally.next : -1));
      reward_dict_.publish(env);
    }
  }

  // --- reward ---

  void dense_reward(Range envs, FloatRows out) override {
    reward_dict_.write(envs, out, [&](int env) {
      return ColorReward{.touches = touch_reward(env),
                         .action_cost = measure_action_cost(engine_, env),
                         .mean_displacement = displacement_.row(env)[0],
                         .max_displacement = displacement_.row(env)[1],
                         .displaced = strong_displacement_[env] != 0,
                         .smoothness = params_.smoothness};
    });
  }

  // --- observation ---

  void observe(Range envs, FloatRows out) override { write_state(*this, envs, out); }

  template <class Visitor>
  void state_row(Visitor& row, int env) const {
    goal_fields(row, env);
    row.field("button_xy", 2, "m", "", [&](RowWriter& out) {
      out.add(button_.center(env).x());
      out.add(button_.center(env).y());
    });
    row.field("button_pressed", 1, "", "the button has been pressed and released",
              [&] { return button_pressed_[env]; });
    cube_fields(row, env, [&] { return is_acting(env) ? count_touches(env).next : -1; });
  }

  // --- expert ---

  const Expert& expert() const override { return expert_; }
  const Annotator* annotator() const override { return &annotator_; }

 private:
  // Goal vector: to the button once it may be pressed, until it has been. next: the colour to be
  // touched, -1: none.
  Eigen::Vector3d goal(int env, int next) const {
    if (button_pressable_[env] != 0 && button_pressed_[env] == 0) {
      const Vec2 center = button_.center(env);
      return Eigen::Vector3d(center.x(), center.y(), button_.top_height() + 0.005) - tcp_pos(env);
    }
    if (next < 0) return {0, 0, 0};
    return touch_.touch_point(env, next) - tcp_pos(env);
  }

  PressButton button_;
  Column<double> displacement_;  // (2) m: mean and largest
  Column<std::uint8_t> strong_displacement_;
  Column<float> max_displacement_;
  Column<std::uint8_t> button_pressed_;
  Column<std::uint8_t> button_pressable_;
  Column<float> press_depth_;
  Column<float> distance_to_button_;
  ColorRecallExpert expert_;
  ColorRecallAnnotator annotator_;
};

template <const auto& kVariants>
std::unique_ptr<Task> make_color_task(const RegistryEntry& entry, const ConstantTable& constants) {
  return entry.is_rl() ? make_variant<ColorTouch, kVariants>(entry, constants)
                       : make_variant<ColorRecall, kVariants>(entry, constants);
}

}  // namespace

constexpr auto kSeqRows = rows_of(kSeqVariants);
constexpr auto kChainRows = rows_of(kChainVariants);
constexpr auto kBunchRows = rows_of(kBunchVariants);

const Family kSeqOfColors = {
    .name = "SeqOfColors",
    .memory_type = "Capacity",
    .instruction =
        "Observe which colored cubes appear during the cue, wait, then touch all of them in "
        "any order and press the center button.",
    .tasks = kSeqRows,
    .make = make_color_task<kSeqVariants>,
    .expectations = {.min_reward = -0.25, .max_reward = 0.2288, .hides = true},
    .memory = {.any_order = true,
               .answer_cut = AnswerCut::kDigits,
               .irrelevant = CounterfactualChange::kOrder,
               .delay = "EMPTY_PHASE_STEPS",
               .items = "SEQUENCE_LENGTH"}};

const Family kChainOfColors = {
    .name = "ChainOfColors",
    .memory_type = "Sequential",
    .instruction =
        "Observe which colored cubes appear during the cue, wait, then touch all of them in "
        "the same order as the cubes were shown and press the center button.",
    .tasks = kChainRows,
    .make = make_color_task<kChainVariants>,
    .expectations = {.min_reward = -0.275, .max_reward = 0.2288, .hides = true},
    .memory = {.answer_cut = AnswerCut::kDigits,
               .irrelevant = CounterfactualChange::kDraw,
               .irrelevant_draw = "cue_step_duration",
               .delay = "EMPTY_PHASE_STEPS",
               .items = "SEQUENCE_LENGTH"}};

const Family kBunchOfColors = {
    .name = "BunchOfColors",
    .memory_type = "Capacity",
    .instruction =
        "Observe which colored cubes appear during the cue, wait, then touch all of them in "
        "any order and press the center button.",
    .tasks = kBunchRows,
    .make = make_color_task<kBunchVariants>,
    .expectations = {.min_reward = -0.25, .max_reward = 0.2288, .hides = true},
    .memory = {.any_order = true,
               .answer_cut = AnswerCut::kDigits,
               .irrelevant = CounterfactualChange::kDraw,
               .irrelevant_draw = "cue_steps",
               .delay = "EMPTY_PHASE_STEPS",
               .items = "SEQUENCE_LENGTH"}};

}  // namespace engram::tasks
