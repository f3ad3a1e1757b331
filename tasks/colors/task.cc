#include "tasks/colors/task.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "core/picture/overlay.h"
#include "mjcf/scene.h"
#include "tasks/colors/params.h"
#include "tasks/parts/colors.h"
#include "tasks/parts/reward_dict.h"
#include "tasks/parts/task_info.h"
#include "tasks/parts/tool_servo.h"
#include "tasks/parts/touch_latch.h"

namespace engram::tasks {
namespace {

constexpr double kTouchHeight = CUBE_HALFSIZE + 0.005;  // of touch points above a cube's centre
constexpr int kStabiliseSteps = 5;  // in which cubes are put back after they appear
constexpr double kUpright[4] = {1, 0, 0, 0};

class ColorRecall final : public Task {
 public:
  ColorRecall(const RegistryEntry& entry, const ColorRecallParams& params)
      : params_(params),
        rule_(params.rule),
        slots_(arc_slots()),
        scene_(cubes()),
        touch_(
            {COLORS, kTouchHeight, params.rule == ColorRule::kBunch ? 0 : params.SEQUENCE_LENGTH}),
        button_(scene_, "center_button", params.button) {
    info_ = describe(entry);
    describe_color_recall(params, info_);
  }

  const TaskInfo& info() const override { return info_; }
  SceneSource scene() const override { return scene_source(scene_); }
  std::string document() const override { return mjcf::compose(scene_, mjcf::Detail::kFull); }

  void bind(const Bindings& bindings) override {
    engine_ = bindings;
    ColumnStore& memory = *bindings.memory;
    clock_.bind(memory);
    const double touch_radius = bindings.options[kTouchRadius];
    touch_.bind(bindings, touch_radius);
    if (params_.rule == ColorRule::kSeq && bindings.options[kStrictOrder] != 0) {
      rule_ = ColorRule::kSeqStrict;
    }
    above_touch_.z() = std::min(kAboveTouch, 0.6 * touch_radius);
    button_.bind(bindings);
    reward_dict_.bind(bindings, kColorRewardTerms);
    sequence_ = memory.add<std::int32_t>("sequence", params_.SEQUENCE_LENGTH);
    memory.limit("sequence", 0, COLORS - 1);
    positions_ = memory.add<double>("positions", 2 * COLORS, "m");
    goal_ = memory.add<double>("obj_to_goal_pos", 3, "m");
    displacement_ = memory.add<double>("displacement", 2, "m", "mean, largest");
    bind_info(*bindings.outputs);
  }

  int cue_end(int env) const override { return clock_.cue_end(env); }

  // --- sampling (buttons 4.2) ---

  void reset(const Episode& episode) override {
    const int env = episode.env();
    draw_sequence(episode);
    draw_positions(episode);
    const int items = params_.rule == ColorRule::kBunch ? 1 : params_.SEQUENCE_LENGTH;
    clock_.reset(env, items * episode.integer(kCueSteps, params_.cue.low, params_.cue.high),
                 episode.integer(kEmptySteps, params_.EMPTY_PHASE_STEPS.low,
                                 params_.EMPTY_PHASE_STEPS.high));
    touch_.reset(env);
    Vec2 center(BUTTON_X_SHIFT_TOWARD_ROBOT, 0);
    for (int color = 0; color < COLORS; ++color) center += slot(env, color) / COLORS;
    button_.reset(env, center);
  }

  // --- phases (buttons 4.3) ---

  void advance(Range envs) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      const int elapsed = engine_.state->elapsed[env];
      switch (clock_.phase(env, elapsed)) {
        case Phase::kCue:
          show_cue(env, elapsed);
          break;
        case Phase::kEmpty:
          if (clock_.begins(env, elapsed)) hide_all(env, params_.SEQUENCE_LENGTH);
          break;
        case Phase::kManipulation:
          if (elapsed < clock_.manipulation_start(env) + kStabiliseSteps) show_all(env);
          break;
      }
      button_.follow_tool(env, is_acting(env));
    }
  }

  // --- touches, button and success (buttons 4.4 to 4.7) ---

  void evaluate(Range envs) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      const bool acting = is_acting(env);
      measure_displacement(env);
      const bool displaced = acting && displacement_.row(env)[1] > MAX_ALLOWED_CUBE_DISPLACEMENT;
      touch_.evaluate(env, acting);
      const TouchTally tally = count_touches(env);
      const bool pressable = tally.complete() && !displaced && acting;
      const PressEvents events = button_.press_and_lift(env, acting, pressable);
      button_pressed_[env] |= events.confirmed ? 1 : 0;
      const bool still = robot_is_static(*engine_.state, env);
      engine_.success[env] = pressable && button_pressed_[env] != 0 && still ? 1 : 0;

      button_pressable_[env] = pressable ? 1 : 0;
      strong_displacement_[env] = displaced ? 1 : 0;
      is_robot_static_[env] = still ? 1 : 0;
      max_displacement_[env] = static_cast<float>(displacement_.row(env)[1]);
      press_depth_[env] = static_cast<float>(button_.depth(env));
      distance_to_button_[env] = static_cast<float>(button_.distance(env));
      std::copy_n(sequence_.row(env), params_.SEQUENCE_LENGTH, engine_.oracle_info.row(env));
      aim(env, acting ? tally.next : -1);
      reward_dict_.publish(env);
    }
  }

  // --- reward (buttons 4.10) ---

  void dense_reward(Range envs, FloatRows out) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      const TouchTally tally = count_touches(env);
      ColorRewardInputs in;
      in.goal_distance = Eigen::Map<const Eigen::Vector3d>(goal_.row(env)).norm();
      in.haste = measure_haste(engine_, env);
      in.correct = tally.correct;
      in.wrong = tally.wrong;
      in.length = params_.SEQUENCE_LENGTH;
      in.mean_displacement = displacement_.row(env)[0];
      in.acting = is_acting(env);
      in.success = engine_.success[env] != 0;
      const ColorRewardTerms terms = color_reward(in, kColorSmoothness);
      *out.row(env) = static_cast<float>(terms.reward);
      note_terms(env, tally, terms);
    }
  }

  // --- observation (buttons 4.9) ---

  void observe(Range envs, FloatRows out) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      float* row = out.row(env);
      const auto put = [&row](double value) { *row++ = static_cast<float>(value); };
      const std::span<const std::int32_t> targets = sequence(env);
      const int next = is_acting(env) ? count_touches(env).next : -1;
      for (int i = 0; i < 3; ++i) put(goal_.row(env)[i]);
      for (const std::int32_t color : targets) put(color);
      put(button_.center(env).x());
      put(button_.center(env).y());
      put(button_pressed_[env]);
      for (int color = 0; color < COLORS; ++color) {
        for (int i = 0; i < 3; ++i) put(engine_.state->prop_pos_of(env, color)[i]);
        put(touch_.touched(env)[color]);
        put(std::find(targets.begin(), targets.end(), color) != targets.end() ? 1 : 0);
        put(color == next ? 1 : 0);
      }
    }
  }

  // --- oracle (buttons 8.4) ---

  void act(Range envs, bool blind, FloatRows actions) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      float* action = actions.row(env);
      if (!is_acting(env) || button_pressed_[env] != 0) {
        hold_tool(kGripperClosed, action);
        continue;
      }
      std::array<std::int32_t, COLORS> guessed{};
      std::span<const std::int32_t> targets = sequence(env);
      if (blind) targets = guess(env, guessed);
      const int color = choose(env, targets);
      const Eigen::Vector3d goal =
          color < 0 ? button_.next_waypoint(env, kTravelHeight)
                    : glide_down(*engine_.state, env, touch_.touch_point(env, color) + above_touch_,
                                 kTravelHeight);
      servo_tool(*engine_.state, env, goal, kToolDown, kGripperClosed, action);
    }
  }

  // --- overlay (common 11) ---

  void overlay(int env, Overlay& out) const override {
    constexpr double kLeft = 130;  // right of "Target:"
    constexpr double kPitch = 25;
    out.add(OverlayText{{10, 60}, "Target:"});
    double x = kLeft;
    for (const std::int32_t color : sequence(env)) {
      const auto& rgba = COLOR_MAPPING[static_cast<std::size_t>(color)].rgba;
      const auto byte = [&rgba](std::size_t i) { return static_cast<std::uint8_t>(rgba[i]); };
      const std::uint8_t border = touch_.touched(env)[color] != 0 ? 255 : 0;
      out.add(OverlaySwatch{{x, 45}, 15, {byte(0), byte(1), byte(2)}, {border, border, border}});
      x += kPitch;
    }
  }

 private:
  static constexpr double kTravelHeight = 0.115;  // m: the TCP between two touches touches nothing
  static constexpr double kAboveTouch = 0.02;     // m: clear of the cube, even when it overshoots

  static mjcf::Scene cubes() {
    mjcf::Scene scene;
    for (int color = 0; color < COLORS; ++color) {
      scene.props.push_back(
          mjcf::cube("cube_" + std::to_string(color), CUBE_HALFSIZE,
                     to_rgba(COLOR_MAPPING[static_cast<std::size_t>(color)].rgba)));
      // Apart, so that the document by itself shows all of them.
      const Vec2 place = arc_slots()[static_cast<std::size_t>(color)];
      scene.props.back().pos = {place.x(), place.y(), CUBE_HALFSIZE};
    }
    return scene;
  }

  void bind_info(ColumnStore& info) {
    obj_to_goal_pos_ = info.add<float>("obj_to_goal_pos", 3, "m", "next goal minus TCP position");
    is_robot_static_ = info.add<std::uint8_t>("is_robot_static");
    strong_displacement_ = info.add<std::uint8_t>("strong_cube_displacement", 1, "",
                                                  "a cube is too far from where it appeared");
    max_displacement_ = info.add<float>("max_cube_displacement_xy", 1, "m");
    button_pressed_ = info.add<std::uint8_t>("button_pressed");
    button_pressable_ = info.add<std::uint8_t>("button_pressable");
    press_depth_ = info.add<float>("button_press_depth", 1, "m");
    distance_to_button_ = info.add<float>("xy_dist_to_button", 1, "m");
  }

  std::span<const std::int32_t> sequence(int env) const {
    return {sequence_.row(env), static_cast<std::size_t>(params_.SEQUENCE_LENGTH)};
  }
  Vec2 slot(int env, int color) const {
    return {positions_.row(env)[2 * color], positions_.row(env)[2 * color + 1]};
  }
  bool is_acting(int env) const {
    return clock_.phase(env, engine_.state->elapsed[env]) == Phase::kManipulation;
  }
  TouchTally count_touches(int env) const {
    return tally_touches(rule_, sequence(env), {touch_.touched(env), COLORS}, touch_.order(env));
  }

  void draw_sequence(const Episode& episode) const {
    std::int32_t* sequence = sequence_.row(episode.env());
    if (const double* pinned = episode.pinned(kSequence)) {
      std::transform(pinned, pinned + params_.SEQUENCE_LENGTH, sequence,
                     [](double value) { return static_cast<std::int32_t>(value); });
      return;
    }
    std::array<int, COLORS> colors{};
    episode.stream(kSequence).permutation(colors);
    std::copy_n(colors.begin(), params_.SEQUENCE_LENGTH, sequence);
  }

  void draw_positions(const Episode& episode) const {
    double* positions = positions_.row(episode.env());
    if (const double* pinned = episode.pinned(kPositions)) {
      std::copy_n(pinned, 2 * COLORS, positions);
      return;
    }
    RandomStream random = episode.stream(kPositions);
    const Layout jittered = jitter_slots(slots_, random);
    for (const Vec2& place : assign_slots(jittered, random)) {
      *positions++ = place.x();
      *positions++ = place.y();
    }
  }

  // The cubes of the cue are put back in every step, so that nothing can move them.
  void show_cue(int env, int elapsed) const {
    const std::span<const std::int32_t> targets = sequence(env);
    if (params_.rule == ColorRule::kBunch) {
      if (elapsed == 0) hide_all(env, 0);
      for (const std::int32_t color : targets) place(env, color, bunch_cue_position(color));
      return;
    }
    // In a made-up snapshot the cue need not be a multiple of its items.
    const int duration = std::max(1, clock_.cue_end(env) / params_.SEQUENCE_LENGTH);
    const int item = std::min(elapsed / duration, params_.SEQUENCE_LENGTH - 1);
    if (elapsed % duration == 0) hide_all(env, item);
    place(env, targets[static_cast<std::size_t>(item)], Vec2::Zero());
  }

  // `shown`: how many items of the cue have been shown. Bunch reports hidden cubes above the
  // middle; the others where they stood last, in x and y.
  void hide_all(int env, int shown) const {
    const std::span<const std::int32_t> past = sequence(env).first(static_cast<std::size_t>(shown));
    for (int color = 0; color < COLORS; ++color) {
      const bool middle = params_.rule == ColorRule::kBunch ||
                          std::find(past.begin(), past.end(), color) != past.end();
      const Vec2 at = middle ? Vec2(0, 0) : slot(env, color);
      const double pos[3] = {at.x(), at.y(), kHiddenHeight};
      engine_.state->hide_prop(env, color, pos);
    }
  }

  void show_all(int env) const {
    for (int color = 0; color < COLORS; ++color) place(env, color, slot(env, color));
  }

  void place(int env, int color, const Vec2& at) const {
    const double pos[3] = {at.x(), at.y(), CUBE_HALFSIZE};
    engine_.state->place_prop(env, color, pos, kUpright);
  }

  // Of the reported poses, whatever the phase.
  void measure_displacement(int env) const {
    double sum = 0;
    double largest = 0;
    for (int color = 0; color < COLORS; ++color) {
      const double* pos = engine_.state->prop_pos_of(env, color);
      const double distance = (Vec2(pos[0], pos[1]) - slot(env, color)).norm();
      sum += distance;
      largest = std::max(largest, distance);
    }
    displacement_.row(env)[0] = sum / COLORS;
    displacement_.row(env)[1] = largest;
  }

  // The goal vector: to the button once it may be pressed, until it has been.
  void aim(int env, int next) const {
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

  void note_terms(int env, const TouchTally& tally, const ColorRewardTerms& terms) const {
    const auto flag = [](bool value) { return value ? 1.0 : 0.0; };
    const std::array<double, kColorRewardTerms> row = {terms.reaching,
                                                       static_cast<double>(tally.correct),
                                                       static_cast<double>(tally.wrong),
                                                       flag(is_robot_static_[env] != 0),
                                                       static_cast<double>(tally.touched),
                                                       static_cast<double>(params_.SEQUENCE_LENGTH),
                                                       flag(tally.all_touched),
                                                       flag(tally.no_extra),
                                                       terms.smooth.action_l2,
                                                       terms.smooth.action_delta_l2,
                                                       terms.smooth.qvel_l2,
                                                       terms.smooth.penalty,
                                                       displacement_.row(env)[0],
                                                       displacement_.row(env)[1],
                                                       terms.displacement_penalty,
                                                       flag(strong_displacement_[env] != 0)};
    reward_dict_.note(env, row);
  }

  // The next of the cubes to be touched, -1 if all have been. Without an order, the row of cubes is
  // swept from the end that is nearer.
  int choose(int env, std::span<const std::int32_t> targets) const {
    int ends[2] = {-1, -1};
    double angles[2] = {0, 0};
    for (const std::int32_t color : targets) {
      if (touch_.touched(env)[color] != 0) continue;
      if (rule_ == ColorRule::kSeqStrict || rule_ == ColorRule::kChain) return color;
      const Vec2 at = slot(env, color);
      const double angle = std::atan2(at.y(), at.x() - kArcX);
      for (int end = 0; end < 2; ++end) {
        const bool further = end == 0 ? angle < angles[end] : angle > angles[end];
        if (ends[end] >= 0 && !further) continue;
        ends[end] = color;
        angles[end] = angle;
      }
    }
    if (ends[0] < 0) return -1;
    const Eigen::Map<const Eigen::Vector3d> tcp(engine_.state->tcp_pos.row(env));
    const auto distance = [&](int color) { return (slot(env, color) - tcp.head<2>()).norm(); };
    return distance(ends[0]) <= distance(ends[1]) ? ends[0] : ends[1];
  }

  // What an agent without memory would touch, one after another.
  std::span<const std::int32_t> guess(int env, std::array<std::int32_t, COLORS>& storage) const {
    const State& state = *engine_.state;
    RandomStream random(state.seed[env], state.episode[env], kPurposeBlindGuess);
    random.permutation(storage);
    return std::span(storage).first(static_cast<std::size_t>(params_.SEQUENCE_LENGTH));
  }

  ColorRecallParams params_;
  ColorRule rule_;  // by which touches are judged
  TaskInfo info_;
  Layout slots_;
  mjcf::Scene scene_;
  Bindings engine_;
  PhaseClock clock_;
  TouchLatch touch_;
  PressButton button_;
  Eigen::Vector3d above_touch_{0, 0, 0};  // where the oracle stops, from the touch point
  RewardDict reward_dict_;
  Column<std::int32_t> sequence_;  // (SEQUENCE_LENGTH) colours of the cue
  Column<double> positions_;       // (COLORS * 2) m: where the cubes stand in the action phase
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
};

}  // namespace

std::unique_ptr<Task> make_color_recall(const RegistryEntry& entry) {
  return std::make_unique<ColorRecall>(entry, color_recall_params(entry.id));
}

}  // namespace engram::tasks
