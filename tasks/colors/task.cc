#include "tasks/colors/task.h"

#include <algorithm>
#include <array>
#include <span>

#include "core/base/index.h"
#include "core/image/overlay.h"
#include "tasks/colors/annotator.h"
#include "tasks/colors/cubes.h"
#include "tasks/colors/expert.h"
#include "tasks/colors/params.h"
#include "tasks/common/colors.h"
#include "tasks/common/family_base.h"
#include "tasks/common/phase_clock.h"
#include "tasks/common/reward_dict.h"
#include "tasks/common/touch_latch.h"
#include "tasks/common/variant.h"

namespace engram::tasks {
namespace {

constexpr double kTouchGap = 0.005;  // m: touch points are that far above a cube
constexpr int kStabiliseSteps = 5;   // in which cubes are put back after they appear

class ColorRecall final : public FamilyBase {
 public:
  ColorRecall(const RegistryEntry& entry, const ColorRecallParams& params)
      : FamilyBase(entry),
        params_(params),
        variables_(RandomVariables(info_.random_variables), params),
        options_(TaskOptions(info_.options), params),
        rule_(params.rule),
        cubes_(scene_, params, variables_.positions),
        touch_({params.COLORS, params.CUBE_HALFSIZE + kTouchGap, params.SEQUENCE_LENGTH}),
        button_(scene_, "center_button", params.button),
        expert_({.engine = engine_,
                 .info = info_,
                 .params = params_,
                 .rule = rule_,
                 .cubes = cubes_,
                 .clock = clock_,
                 .touch = touch_,
                 .button = button_,
                 .sequence = sequence_,
                 .button_pressed = button_pressed_}),
        annotator_(expert_) {
    describe_color_recall(params, info_);
    info_.reward_terms =
        reward_terms_of([&](auto& row) { list_color_terms(row, params.rule, {}, {}); });
    declare_state(*this);
    declare_sampled_values(*this);
  }

  void bind(const Bindings& bindings) override {
    FamilyBase::bind(bindings);
    ColumnStore& memory = *bindings.memory;
    clock_.bind(memory);
    touch_.bind(bindings, options_.touch_radius.value(bindings));
    const auto& strict_order = options_.strict_order;
    if (strict_order && strict_order->is_on(bindings)) rule_ = ColorRule::kSeqStrict;
    button_.bind(bindings);
    reward_dict_.bind(bindings, info_.reward_terms.size());
    sequence_ = memory.add<std::int32_t>("sequence", params_.SEQUENCE_LENGTH);
    memory.limit("sequence", 0, params_.COLORS - 1);
    cubes_.bind(bindings);
    goal_ = memory.add<double>("obj_to_goal_pos", 3, "m");
    displacement_ = memory.add<double>("displacement", 2, "m", "mean, largest");
    bind_info(*bindings.outputs);
  }

  int cue_end(int env) const override { return clock_.cue_end(env); }
  void sampled_values(int env, float* out) const override { write_sampled_values(*this, env, out); }
  template <class Row>
  void sampled_row(Row& row, int env) const {
    clock_.sampled_row(row, env);
  }

  // --- sampling ---

  void reset(const Episode& episode) override {
    const int env = episode.env();
    draw_sequence(episode);
    cubes_.reset(episode);
    clock_.reset(env, params_.cue_items() * variables_.cue_steps.sample(episode),
                 variables_.empty_steps.sample(episode));
    touch_.reset(env);
    button_.reset(env, cubes_.button_center(env));
  }

  // --- phases ---

  void advance(Range envs) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      const int elapsed = engine_.state->elapsed[env];
      switch (clock_.phase(env, elapsed)) {
        case Phase::kCue:
          cubes_.show_cue(env, sequence(env), elapsed, clock_.cue_end(env));
          break;
        case Phase::kEmpty:
          if (clock_.begins(env, elapsed)) cubes_.hide_all(env, sequence(env));
          break;
        case Phase::kManipulation:
          if (elapsed < clock_.manipulation_start(env) + kStabiliseSteps) cubes_.show_all(env);
          break;
      }
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
      touch_.evaluate(env, acting);
      const TouchTally tally = count_touches(env);
      if (tally.mistaken || tally.complete()) {
        const int number = answer_number(touch_.order(env), params_.SEQUENCE_LENGTH);
        engine_.answers.give(env, number, tally.complete());
      }
      const bool pressable = tally.complete() && !displaced && acting;
      const PressEvents events = button_.press_and_lift(env, acting, pressable);
      button_pressed_[env] |= events.confirmed ? 1 : 0;
      const bool still = robot_is_static(*engine_.state, env);
      engine_.success[env] = pressable && button_pressed_[env] != 0 && still ? 1 : 0;

      button_pressable_[env] = pressable ? 1 : 0;
      strong_displacement_[env] = displaced ? 1 : 0;
      is_robot_static_[env] = still ? 1 : 0;
      max_displacement_[env] = static_cast<float>(moved.largest);
      press_depth_[env] = static_cast<float>(button_.depth(env));
      distance_to_button_[env] = static_cast<float>(button_.distance(env));
      std::copy_n(sequence_.row(env), params_.SEQUENCE_LENGTH, engine_.oracle_info.row(env));
      update_goal(env, acting ? tally.next : -1);
      reward_dict_.publish(env);
    }
  }

  // --- reward ---

  void dense_reward(Range envs, FloatRows out) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      ColorRewardInputs in;
      in.goal_distance = Eigen::Map<const Eigen::Vector3d>(goal_.row(env)).norm();
      in.action_cost = measure_action_cost(engine_, env);
      in.tally = count_touches(env);
      in.length = params_.SEQUENCE_LENGTH;
      in.mean_displacement = displacement_.row(env)[0];
      in.max_displacement = displacement_.row(env)[1];
      in.acting = is_acting(env);
      in.success = engine_.success[env] != 0;
      in.displaced = strong_displacement_[env] != 0;
      in.robot_static = is_robot_static_[env] != 0;
      const ColorRewardTerms terms = color_reward(in, params_.smoothness);
      *out.row(env) = static_cast<float>(terms.reward);
      reward_dict_.note(env, [&](auto& row) { list_color_terms(row, rule_, in, terms); });
    }
  }

  // --- observation ---

  void observe(Range envs, FloatRows out) override { write_state(*this, envs, out); }

  template <class Row>
  void state_row(Row& row, int env) const {
    row.field("obj_to_goal_pos", 3, "m", "touch point of the next target minus TCP",
              [&] { return goal_.row(env); });
    row.field("oracle_info", params_.SEQUENCE_LENGTH, "", "colours of the cue, in its order",
              [&] { return sequence_.row(env); });
    row.field("button_xy", 2, "m", "", [&](RowWriter& out) {
      out.add(button_.center(env).x());
      out.add(button_.center(env).y());
    });
    row.field("button_pressed", 1, "", "the button has been pressed and released",
              [&] { return button_pressed_[env]; });
    int next = -1;
    if constexpr (std::is_same_v<Row, RowWriter>) next = next_target(env);
    for (int color = 0; color < params_.COLORS; ++color) {
      row.field(NumberedName{"cube_", color, "_pose"}, 3, "m", "position",
                [&] { return engine_.state->prop_pos_of(env, color); });
      row.field(NumberedName{"touched_", color, ""}, 1, "", "has been touched",
                [&] { return touch_.touched(env)[color]; });
      row.field(NumberedName{"cube_", color, "_in_seq"}, 1, "", "is one of the cue's",
                [&] { return in_sequence(env, color) ? 1 : 0; });
      row.field(NumberedName{"next_target_", color, ""}, 1, "", "is to be touched next",
                [&] { return color == next ? 1 : 0; });
    }
  }

  // --- expert ---

  const Expert& expert() const override { return expert_; }
  const Annotator* annotator() const override { return &annotator_; }

  // --- overlay ---

  void overlay(int env, Overlay& out) const override {
    constexpr double kLeft = 130;  // right of "Target:"
    constexpr double kPitch = 25;
    out.add(OverlayText{{10, 60}, "Target:"});
    double x = kLeft;
    for (const std::int32_t color : sequence(env)) {
      const auto& rgba = COLOR_MAPPING[at(color)].rgba;
      const auto byte = [&rgba](std::size_t i) { return static_cast<std::uint8_t>(rgba[i]); };
      const std::uint8_t border = touch_.touched(env)[color] != 0 ? 255 : 0;
      out.add(OverlaySwatch{{x, 45}, 15, {byte(0), byte(1), byte(2)}, {border, border, border}});
      x += kPitch;
    }
  }

 private:
  void bind_info(ColumnStore& info) {
    obj_to_goal_pos_ =
        info.add_privileged<float>("obj_to_goal_pos", 3, "m", "next goal minus TCP position");
    is_robot_static_ = info.add<std::uint8_t>("is_robot_static");
    strong_displacement_ = info.add<std::uint8_t>("strong_cube_displacement", 1, "",
                                                  "a cube is too far from where it appeared");
    max_displacement_ = info.add_privileged<float>("max_cube_displacement_xy", 1, "m");
    button_pressed_ = info.add<std::uint8_t>("button_pressed");
    button_pressable_ = info.add<std::uint8_t>("button_pressable");
    press_depth_ = info.add<float>("button_press_depth", 1, "m");
    distance_to_button_ = info.add<float>("xy_dist_to_button", 1, "m");
  }

  std::span<const std::int32_t> sequence(int env) const {
    return {sequence_.row(env), at(params_.SEQUENCE_LENGTH)};
  }
  bool in_sequence(int env, int color) const {
    const std::span<const std::int32_t> colors = sequence(env);
    return std::find(colors.begin(), colors.end(), color) != colors.end();
  }
  bool is_acting(int env) const {
    return clock_.phase(env, engine_.state->elapsed[env]) == Phase::kManipulation;
  }
  TouchTally count_touches(int env) const {
    return tally_touches(rule_, sequence(env), {touch_.touched(env), at(params_.COLORS)},
                         touch_.order(env));
  }
  // The colour to be touched next, -1: none.
  int next_target(int env) const { return is_acting(env) ? count_touches(env).next : -1; }

  void draw_sequence(const Episode& episode) const {
    std::int32_t* sequence = sequence_.row(episode.env());
    if (const double* pinned = variables_.sequence.pinned(episode)) {
      std::transform(pinned, pinned + params_.SEQUENCE_LENGTH, sequence,
                     [](double value) { return static_cast<std::int32_t>(value); });
      return;
    }
    ColorPermutation storage{};
    const std::span colors =
        shuffled_colors(params_.COLORS, storage, variables_.sequence.stream(episode));
    std::copy_n(colors.begin(), params_.SEQUENCE_LENGTH, sequence);
  }

  // Goal vector: to the button once it may be pressed, until it has been.
  void update_goal(int env, int next) const {
    const Eigen::Map<const Eigen::Vector3d> tcp(engine_.state->tcp_pos.row(env));
    Eigen::Map<Eigen::Vector3d> goal(goal_.row(env));
    goal.setZero();
    if (button_pressable_[env] != 0 && button_pressed_[env] == 0) {
      const Vec2 center = button_.center(env);
      goal = Eigen::Vector3d(center.x(), center.y(), button_.top_height() + 0.005) - tcp;
    } else if (next >= 0) {
      goal = touch_.touch_point(env, next) - tcp;
    }
    for (int i = 0; i < 3; ++i) obj_to_goal_pos_.row(env)[i] = static_cast<float>(goal[i]);
  }

  ColorRecallParams params_;
  ColorVariables variables_;
  ColorOptions options_;
  ColorRule rule_;  // by which touches are judged
  ColorCubes cubes_;
  PhaseClock clock_;
  TouchLatch touch_;
  PressButton button_;
  RewardDict reward_dict_;
  Column<std::int32_t> sequence_;  // (SEQUENCE_LENGTH) colours of the cue
  Column<double> goal_;            // (3) m: obj_to_goal_pos in full precision
  Column<double> displacement_;    // (2) m: mean and largest
  Column<float> obj_to_goal_pos_;  // (3) m
  Column<std::uint8_t> is_robot_static_;
  Column<std::uint8_t> strong_displacement_;
  Column<float> max_displacement_;
  Column<std::uint8_t> button_pressed_;
  Column<std::uint8_t> button_pressable_;
  Column<float> press_depth_;
  Column<float> distance_to_button_;
  ColorRecallExpert expert_;
  ColorRecallAnnotator annotator_;
};

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
    .make = make_variant<ColorRecall, kSeqVariants>,
    .expectations = {.least_reward = -0.25, .most_reward = 0.2288, .hides = true},
    .memory = {.any_order = true,
               .irrelevant = PastChange::kOrder,
               .delay = "EMPTY_PHASE_STEPS",
               .items = "SEQUENCE_LENGTH"}};

const Family kChainOfColors = {
    .name = "ChainOfColors",
    .memory_type = "Sequential",
    .instruction =
        "Observe which colored cubes appear during the cue, wait, then touch all of them in "
        "the same order as the cubes were shown and press the center button.",
    .tasks = kChainRows,
    .make = make_variant<ColorRecall, kChainVariants>,
    .expectations = {.least_reward = -0.275, .most_reward = 0.2288, .hides = true},
    .memory = {.irrelevant = PastChange::kDraw,
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
    .make = make_variant<ColorRecall, kBunchVariants>,
    .expectations = {.least_reward = -0.25, .most_reward = 0.2288, .hides = true},
    .memory = {.any_order = true,
               .irrelevant = PastChange::kDraw,
               .irrelevant_draw = "cue_steps",
               .delay = "EMPTY_PHASE_STEPS",
               .items = "SEQUENCE_LENGTH"}};

}  // namespace engram::tasks
