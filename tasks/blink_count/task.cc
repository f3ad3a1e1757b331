#include "tasks/blink_count/task.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/picture/overlay.h"
#include "mjcf/scene.h"
#include "tasks/blink_count/reward.h"
#include "tasks/parts/lamp.h"
#include "tasks/parts/phase_clock.h"
#include "tasks/parts/press_button.h"
#include "tasks/parts/reward_dict.h"
#include "tasks/parts/task_info.h"
#include "tasks/parts/tool_servo.h"
#include "tasks/parts/variant.h"

namespace engram::tasks {
namespace {

// --- parameters (buttons 1.2) ---

struct Params {
  std::string_view id;
  StepRange BLINK_COUNT_RANGE;
  StepRange PRE_BLINK_OFF_STEPS;
};

constexpr std::array<Params, 6> kVariants = {{
    {"BlinkCountButtonPressEasy-VLA-v0", {1, 3}, {5, 10}},
    {"BlinkCountButtonPressMedium-VLA-v0", {1, 5}, {5, 10}},
    {"BlinkCountButtonPressHard-VLA-v0", {1, 7}, {5, 10}},
    {"BlinkCountButtonPressEasy-Long-VLA-v0", {1, 10}, {5, 50}},
    {"BlinkCountButtonPressMedium-Long-VLA-v0", {10, 20}, {5, 50}},
    {"BlinkCountButtonPressHard-Long-VLA-v0", {20, 30}, {5, 50}},
}};

constexpr StepRange BLINK_ON_STEPS{3, 3};
constexpr StepRange BLINK_OFF_STEPS{3, 5};
constexpr double CONFIRM_BUTTON_Y_OFFSET = 0.16;   // m
constexpr double kConfirmYLimit = 0.28;            // m
constexpr double INDICATOR_FORWARD_OFFSET = 0.22;  // m
constexpr double PHASE_INDICATOR_X_OFFSET = 0.2;   // m, towards -y despite its name
constexpr double INDICATOR_HEIGHT = 0;             // m
constexpr double kButtonX[2] = {-0.15, -0.05};     // m
constexpr double kButtonY[2] = {-0.12, 0.12};      // m

constexpr PressButtonParams kRedButton;
constexpr PressButtonParams kBlackButton = {
    .shape = {.base_rgba = {40 / 255.0, 40 / 255.0, 40 / 255.0, 1},
              .cap_rgba = {20 / 255.0, 20 / 255.0, 20 / 255.0, 1}}};

// What the lamps show (buttons 6.1).
constexpr mjcf::Rgba kBulbGlass = {245 / 255.0, 245 / 255.0, 245 / 255.0, 1};
constexpr mjcf::Rgba PHASE_WAIT_COLOR = {1, 0, 0, 1};
constexpr mjcf::Rgba PHASE_READY_COLOR = {0, 1, 0, 1};
constexpr double kBlinkEmission = 20;
constexpr double kPhaseEmission = 3;

// What an episode samples (buttons 6.2), and the options.
enum DrawIndex { kTargetBlinks, kX, kY, kPreSteps, kOnSteps, kOffSteps };
enum OptionIndex { kBlinkRed, kBlinkGreen, kBlinkBlue };

std::vector<Draw> draws(const Params& params) {
  const int most = params.BLINK_COUNT_RANGE.high;
  const auto steps = [](const char* name, int width, StepRange range, const char* what) {
    return Draw{name,
                width,
                true,
                static_cast<double>(range.low),
                static_cast<double>(range.high),
                "control steps",
                what};
  };
  return {
      {"target_blinks", 1, true, static_cast<double>(params.BLINK_COUNT_RANGE.low),
       static_cast<double>(most), "", "blinks to count"},
      {"button_x", 1, false, kButtonX[0], kButtonX[1], "m", "place of the red button"},
      {"button_y", 1, false, kButtonY[0], kButtonY[1], "m", "place of the red button"},
      steps("pre_blink_off_steps", 1, params.PRE_BLINK_OFF_STEPS, "before the first blink"),
      steps("blink_on_steps", most, BLINK_ON_STEPS, "length of every blink"),
      steps("blink_off_steps", most, BLINK_OFF_STEPS, "darkness after every blink"),
  };
}

Constant color_constant(const mjcf::Rgba& rgba) {
  return ConstantList{rgba[0], rgba[1], rgba[2], rgba[3]};
}

ConstantTable constants(const Params& params) {
  ConstantTable table = {
      {"BLINK_COUNT_RANGE", params.BLINK_COUNT_RANGE.constant()},
      {"PRE_BLINK_OFF_STEPS", params.PRE_BLINK_OFF_STEPS.constant()},
      {"BLINK_ON_STEPS", BLINK_ON_STEPS.constant()},
      {"BLINK_OFF_STEPS", BLINK_OFF_STEPS.constant()},
      {"CONFIRM_BUTTON_Y_OFFSET", CONFIRM_BUTTON_Y_OFFSET},
      {"LAMP_BASE_RADIUS", 0.018},
      {"LAMP_BASE_HALF_HEIGHT", 0.008},
      {"LAMP_STEM_RADIUS", 0.004},
      {"LAMP_STEM_HALF_HEIGHT", 0.020},
      {"LAMP_BULB_RADIUS", 0.012},
      {"INDICATOR_FORWARD_OFFSET", INDICATOR_FORWARD_OFFSET},
      {"PHASE_INDICATOR_X_OFFSET", PHASE_INDICATOR_X_OFFSET},
      {"INDICATOR_HEIGHT", INDICATOR_HEIGHT},
      {"HEIGHT_OFFSET", 1000.0},
      {"DEFAULT_BLINK_COLOR", color_constant({0, 0, 1, 1})},
      {"PHASE_WAIT_COLOR", color_constant(PHASE_WAIT_COLOR)},
      {"PHASE_READY_COLOR", color_constant(PHASE_READY_COLOR)},
      {"ACTION_L2_COEF", kBlinkSmoothness.ACTION_L2_COEF},
      {"ACTION_DELTA_L2_COEF", kBlinkSmoothness.ACTION_DELTA_L2_COEF},
      {"QVEL_L2_COEF", kBlinkSmoothness.QVEL_L2_COEF},
      {"SUCCESS_BONUS", SUCCESS_BONUS},
      {"FAILURE_PENALTY", FAILURE_PENALTY},
  };
  add_constants(kRedButton, table);
  return table;
}

std::vector<TaskOption> options() {
  const auto component = [](const char* name, double value) {
    return TaskOption{name,
                      value,
                      false,
                      0,
                      255,
                      "",
                      "colour of the blinking lamp; 0 to 1, or 0 to 255 if one is above 1"};
  };
  return {component("blink_red", 0), component("blink_green", 0), component("blink_blue", 1)};
}

std::vector<Field> state_fields() {
  std::vector<Field> fields;
  for (const char* name : {"button_base_pose", "button_cap_pose", "confirm_button_base_pose",
                           "confirm_button_cap_pose", "indicator_pose", "phase_indicator_pose"}) {
    fields.push_back({name, 7, DType::kFloat32, "m", "position, quaternion (w, x, y, z)"});
  }
  for (const char* name :
       {"press_count", "target_blinks", "action_mask", "phase_ready", "press_ready",
        "pending_press", "submit_attempted", "submit_success", "at_lift_target", "oracle_info"}) {
    fields.push_back({name, 1, DType::kFloat32, "", ""});
  }
  return fields;
}

class BlinkCount final : public Task {
 public:
  BlinkCount(const RegistryEntry& entry, const Params& params)
      : params_(params),
        scene_{.props = {}, .render_camera = mjcf::RenderCamera::kB},
        red_(scene_, "button", kRedButton),
        black_(scene_, "confirm_button", kBlackButton),
        blink_lamp_(scene_, "blink_lamp"),
        phase_lamp_(scene_, "phase_lamp") {
    info_ = describe(entry);
    info_.candidates = params.BLINK_COUNT_RANGE.high - params.BLINK_COUNT_RANGE.low + 1;
    info_.termination = Termination::kSuccessOrFailed;
    info_.success_reward = SUCCESS_BONUS;
    info_.oracle_dim = 1;
    info_.draws = draws(params);
    info_.hidden_draw = "target_blinks";
    info_.options = options();
    info_.constants = constants(params);
    info_.reward_terms = blink_reward_term_names();
    info_.phases = {{"cue", "elapsed < C: the lamp blinks; presses do not count"},
                    {"action", "elapsed >= C: the phase lamp is green"}};
    info_.state_fields = state_fields();
  }

  const TaskInfo& info() const override { return info_; }
  SceneSource scene() const override { return scene_source(scene_); }
  std::string document() const override { return mjcf::compose(scene_, mjcf::Detail::kFull); }

  void bind(const Bindings& bindings) override {
    engine_ = bindings;
    clock_.bind(*bindings.memory);
    red_.bind(bindings);
    black_.bind(bindings);
    reward_dict_.bind(bindings, kBlinkRewardTerms);
    const int most = params_.BLINK_COUNT_RANGE.high;
    start_ = bindings.memory->add<std::int32_t>("blink_start", most, "control steps");
    length_ = bindings.memory->add<std::int32_t>("blink_length", most, "control steps");
    bind_info(*bindings.outputs);
    bindings.outputs->limit("target_blinks", 0, most);
    set_blink_color(bindings.options);
  }

  int cue_end(int env) const override { return clock_.cue_end(env); }

  // --- sampling (buttons 6.2) ---

  void reset(const Episode& episode) override {
    const int env = episode.env();
    const Vec2 red(episode.real(kX, kButtonX[0], kButtonX[1]),
                   episode.real(kY, kButtonY[0], kButtonY[1]));
    const Vec2 black(
        red.x(), std::clamp(red.y() + CONFIRM_BUTTON_Y_OFFSET, -kConfirmYLimit, kConfirmYLimit));
    red_.reset(env, red);
    black_.reset(env, black);
    const double x = red.x() + INDICATOR_FORWARD_OFFSET;
    const double blink_lamp[3] = {x, red.y(), INDICATOR_HEIGHT};
    const double phase_lamp[3] = {x, red.y() - PHASE_INDICATOR_X_OFFSET, INDICATOR_HEIGHT};
    blink_lamp_.place(*engine_.state, env, blink_lamp);
    phase_lamp_.place(*engine_.state, env, phase_lamp);
    const StepRange count = params_.BLINK_COUNT_RANGE;
    target_[env] = episode.integer(kTargetBlinks, count.low, count.high);
    draw_schedule(episode);
  }

  // --- phases and lamps (buttons 6.3) ---

  void advance(Range envs) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      light_on_[env] = is_lit(env) ? 1 : 0;
      blink_lamp_.shine(
          *engine_.state, env,
          light_on_[env] != 0 ? LampLight{blink_color_, kBlinkEmission} : LampLight{kBulbGlass, 0});
      phase_lamp_.shine(*engine_.state, env,
                        {is_acting(env) ? PHASE_READY_COLOR : PHASE_WAIT_COLOR, kPhaseEmission});
      red_.follow_tool(env, true);
      black_.follow_tool(env, true);
    }
  }

  // --- presses and their outcome (buttons 6.4 to 6.6) ---

  void evaluate(Range envs) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      const bool acting = is_acting(env);
      const PressEvents events = red_.press_and_lift(env, acting, engine_.failed[env] == 0);
      const bool submitted = black_.press_once(env, acting, submit_attempted_[env] == 0);
      raw_press_count_[env] += events.pressed ? 1 : 0;
      press_count_[env] += events.confirmed ? 1 : 0;
      judge(env, acting, submitted);
      show_events(env, events, submitted);
      show_state(env, acting);
      reward_dict_.publish(env);
    }
  }

  // --- reward (buttons 6.9) ---

  void dense_reward(Range envs, FloatRows out) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      BlinkRewardInputs in;
      const Eigen::Map<const Eigen::Vector3d> tcp(engine_.state->tcp_pos.row(env));
      const auto distance = [&tcp](const double* pos) {
        return (Eigen::Map<const Eigen::Vector3d>(pos) - tcp).norm();
      };
      in.height = tcp.z();
      in.xy_distance = red_.distance(env);
      in.cap_distance = distance(red_.cap_pos(env));
      in.black_cap_distance = distance(black_.cap_pos(env));
      in.depth = red_.depth(env);
      in.black_depth = black_.depth(env);
      in.press_count = press_count_[env];
      in.target = target_[env];
      in.pending = red_.pending(env);
      in.start_height = red_.start_height(env);
      in.red = {.released = new_release_event_[env] != 0,
                .pressed = new_raw_press_event_[env] != 0,
                .confirmed = new_press_event_[env] != 0};
      in.submitted = new_confirm_press_event_[env] != 0;
      in.acting = is_acting(env);
      in.failed = engine_.failed[env] != 0;
      in.success = engine_.success[env] != 0;
      in.haste = measure_haste(engine_, env);
      // The first action is compared with zero (6.9).
      if (engine_.state->elapsed[env] <= 1) in.haste.action_delta_norm = in.haste.action_norm;
      const BlinkReward result = blink_reward(in, kRedButton);
      *out.row(env) = static_cast<float>(result.reward);
      reward_dict_.note(env, result.terms);
    }
  }

  // --- observation (buttons 6.8) ---

  void observe(Range envs, FloatRows out) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      float* row = out.row(env);
      const auto put = [&row](double value) { *row++ = static_cast<float>(value); };
      const auto put_pose = [&](const double* pos, const double* quat) {
        for (int i = 0; i < 3; ++i) put(pos[i]);
        for (int i = 0; i < 4; ++i) put(quat[i]);
      };
      for (const PressButton* button : {&red_, &black_}) {
        put_pose(button->base_pos(env), button->base_quat(env));
        put_pose(button->cap_pos(env), button->cap_quat(env));
      }
      for (const Lamp* lamp : {&blink_lamp_, &phase_lamp_}) {
        put_pose(engine_.state->prop_pos_of(env, lamp->bulb()),
                 engine_.state->prop_quat_of(env, lamp->bulb()));
      }
      put(press_count_[env]);
      put(target_[env]);
      put(action_mask_[env]);
      put(phase_ready_[env]);
      put(press_ready_[env]);
      put(pending_press_[env]);
      put(submit_attempted_[env]);
      put(submit_success_[env]);
      put(at_lift_target_[env]);
      put(target_[env]);
    }
  }

  // --- oracle (buttons 8.4) ---

  void act(Range envs, bool blind, FloatRows actions) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      float* action = actions.row(env);
      if (!is_acting(env) || submit_attempted_[env] != 0) {
        hold_tool(kGripperClosed, action);
        continue;
      }
      const bool counting = press_count_[env] < (blind ? guess(env) : target_[env]);
      const PressButton& button = counting ? red_ : black_;
      servo_tool(*engine_.state, env, button.next_waypoint(env, kTravelHeight), kToolDown,
                 kGripperClosed, action);
    }
  }

  // --- overlay (common 11) ---

  void overlay(int env, Overlay& out) const override {
    out.add(OverlayText{{10, 120},
                        "Press raw/conf: " + std::to_string(raw_press_count_[env]) + "/" +
                            std::to_string(press_count_[env]) + "/" + std::to_string(target_[env]),
                        0.8});
  }

 private:
  static constexpr double kTravelHeight = 0.13;  // m: well above both buttons' press zones

  void bind_info(ColumnStore& info) {
    submit_attempted_ = info.add<std::uint8_t>("submit_attempted");
    submit_success_ = info.add<std::uint8_t>("submit_success");
    action_mask_ = info.add<std::uint8_t>("action_mask", 1, "", "presses count");
    phase_ready_ = info.add<std::uint8_t>("phase_ready", 1, "", "the phase lamp is green");
    light_on_ = info.add<std::uint8_t>("light_on", 1, "", "the lamp is lit");
    press_count_ = info.add<std::int32_t>("press_count", 1, "", "presses that were lifted");
    raw_press_count_ = info.add<std::int32_t>("raw_press_count", 1, "", "presses that began");
    target_ = info.add<std::int32_t>("target_blinks");
    new_raw_press_event_ = info.add<std::uint8_t>("new_raw_press_event");
    new_press_event_ = info.add<std::uint8_t>("new_press_event");
    new_release_event_ = info.add<std::uint8_t>("new_release_event");
    new_confirm_press_event_ = info.add<std::uint8_t>("new_confirm_press_event");
    press_ready_ = info.add<std::uint8_t>("press_ready");
    pending_press_ = info.add<std::uint8_t>("pending_press");
    lift_target_z_ = info.add<float>("lift_target_z", 1, "m");
    at_lift_target_ = info.add<std::uint8_t>("at_lift_target");
    xy_dist_to_button_ = info.add<float>("xy_dist_to_button", 1, "m");
    press_depth_ = info.add<float>("press_depth", 1, "m");
    xy_dist_to_confirm_button_ = info.add<float>("xy_dist_to_confirm_button", 1, "m");
    confirm_press_depth_ = info.add<float>("confirm_press_depth", 1, "m");
    obj_to_goal_pos_ = info.add<float>("obj_to_goal_pos", 3, "m", "red cap minus TCP position");
  }

  // One component above 1 tells that all are of 0 to 255.
  void set_blink_color(std::span<const double> values) {
    const double scale = *std::max_element(values.begin(), values.end()) > 1 ? 255.0 : 1.0;
    blink_color_ = {values[kBlinkRed] / scale, values[kBlinkGreen] / scale,
                    values[kBlinkBlue] / scale, 1};
  }

  bool is_acting(int env) const {
    return engine_.state->elapsed[env] >= clock_.manipulation_start(env);
  }

  bool is_lit(int env) const {
    const int elapsed = engine_.state->elapsed[env];
    for (int i = 0; i < target_[env]; ++i) {
      const int start = start_.row(env)[i];
      if (elapsed >= start && elapsed < start + length_.row(env)[i]) return true;
    }
    return false;
  }

  // Every blink and the darkness after it are drawn apart; the cue ends with the last darkness.
  void draw_schedule(const Episode& episode) const {
    const int env = episode.env();
    const double* pinned_on = episode.pinned(kOnSteps);
    const double* pinned_off = episode.pinned(kOffSteps);
    RandomStream on_stream = episode.stream(kOnSteps);
    RandomStream off_stream = episode.stream(kOffSteps);
    const StepRange pre = params_.PRE_BLINK_OFF_STEPS;
    int end = episode.integer(kPreSteps, pre.low, pre.high);
    for (int i = 0; i < target_[env]; ++i) {
      const int on = pinned_on != nullptr
                         ? static_cast<int>(pinned_on[i])
                         : on_stream.integer(BLINK_ON_STEPS.low, BLINK_ON_STEPS.high);
      const int off = pinned_off != nullptr
                          ? static_cast<int>(pinned_off[i])
                          : off_stream.integer(BLINK_OFF_STEPS.low, BLINK_OFF_STEPS.high);
      start_.row(env)[i] = end;
      length_.row(env)[i] = on;
      end += on + off;
    }
    clock_.reset(env, end, 0);
  }

  void judge(int env, bool acting, bool submitted) const {
    const bool correct = press_count_[env] == target_[env];
    const bool failed = engine_.failed[env] != 0 || raw_press_count_[env] > target_[env];
    if (submitted) submit_attempted_[env] = 1;
    if (submitted && correct && !failed) submit_success_[env] = 1;
    engine_.failed[env] = failed || (submitted && !correct) ? 1 : 0;
    engine_.success[env] = acting && submit_success_[env] != 0 ? 1 : 0;
  }

  void show_events(int env, const PressEvents& events, bool submitted) const {
    new_raw_press_event_[env] = events.pressed ? 1 : 0;
    new_press_event_[env] = events.confirmed ? 1 : 0;
    new_release_event_[env] = events.released ? 1 : 0;
    new_confirm_press_event_[env] = submitted ? 1 : 0;
  }

  void show_state(int env, bool acting) const {
    engine_.oracle_info[env] = target_[env];
    action_mask_[env] = phase_ready_[env] = acting ? 1 : 0;
    press_ready_[env] = red_.ready(env) ? 1 : 0;
    pending_press_[env] = red_.pending(env) ? 1 : 0;
    at_lift_target_[env] = red_.at_lift_target(env) ? 1 : 0;
    lift_target_z_[env] = static_cast<float>(red_.lift_target(env));
    xy_dist_to_button_[env] = static_cast<float>(red_.distance(env));
    press_depth_[env] = static_cast<float>(red_.depth(env));
    xy_dist_to_confirm_button_[env] = static_cast<float>(black_.distance(env));
    confirm_press_depth_[env] = static_cast<float>(black_.depth(env));
    for (int i = 0; i < 3; ++i) {
      obj_to_goal_pos_.row(env)[i] =
          static_cast<float>(red_.cap_pos(env)[i] - engine_.state->tcp_pos.row(env)[i]);
    }
  }

  // How often an agent without memory would press.
  int guess(int env) const {
    const State& state = *engine_.state;
    RandomStream random(state.seed[env], state.episode[env], kPurposeBlindGuess);
    return random.integer(params_.BLINK_COUNT_RANGE.low, params_.BLINK_COUNT_RANGE.high);
  }

  Params params_;
  TaskInfo info_;
  mjcf::Scene scene_;
  mjcf::Rgba blink_color_{};
  Bindings engine_;
  PhaseClock clock_;
  PressButton red_;
  PressButton black_;
  Lamp blink_lamp_;
  Lamp phase_lamp_;
  RewardDict reward_dict_;
  Column<std::int32_t> start_;   // (most blinks) elapsed at which each begins
  Column<std::int32_t> length_;  // (most blinks) control steps
  // Info; counters and latches are kept in it.
  Column<std::uint8_t> submit_attempted_;
  Column<std::uint8_t> submit_success_;
  Column<std::uint8_t> action_mask_;
  Column<std::uint8_t> phase_ready_;
  Column<std::uint8_t> light_on_;
  Column<std::int32_t> press_count_;
  Column<std::int32_t> raw_press_count_;
  Column<std::int32_t> target_;
  Column<std::uint8_t> new_raw_press_event_;
  Column<std::uint8_t> new_press_event_;
  Column<std::uint8_t> new_release_event_;
  Column<std::uint8_t> new_confirm_press_event_;
  Column<std::uint8_t> press_ready_;
  Column<std::uint8_t> pending_press_;
  Column<float> lift_target_z_;
  Column<std::uint8_t> at_lift_target_;
  Column<float> xy_dist_to_button_;
  Column<float> press_depth_;
  Column<float> xy_dist_to_confirm_button_;
  Column<float> confirm_press_depth_;
  Column<float> obj_to_goal_pos_;  // (3) m
};

}  // namespace

std::unique_ptr<Task> make_blink_count(const RegistryEntry& entry) {
  return std::make_unique<BlinkCount>(entry, find_variant(kVariants, entry.id));
}

}  // namespace engram::tasks
