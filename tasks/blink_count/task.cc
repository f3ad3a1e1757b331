#include "tasks/blink_count/task.h"

#include <algorithm>
#include <span>
#include <string>

#include "core/image/overlay.h"
#include "tasks/blink_count/annotator.h"
#include "tasks/blink_count/blinks.h"
#include "tasks/blink_count/expert.h"
#include "tasks/blink_count/params.h"
#include "tasks/blink_count/reward.h"
#include "tasks/common/family_base.h"
#include "tasks/common/lamp.h"
#include "tasks/common/phase_clock.h"
#include "tasks/common/press_button.h"
#include "tasks/common/reward_dict.h"
#include "tasks/common/variant.h"

namespace engram::tasks {
namespace {

constexpr double kConfirmYLimit = 0.28;  // m: the black button stands no farther out
constexpr mjcf::Rgba kBulbGlass = {245 / 255.0, 245 / 255.0, 245 / 255.0, 1};
constexpr double kBlinkEmission = 20;
constexpr double kPhaseEmission = 3;

PressButtonParams in_black(PressButtonParams button) {
  button.shape.base_rgba = {40 / 255.0, 40 / 255.0, 40 / 255.0, 1};
  button.shape.cap_rgba = {20 / 255.0, 20 / 255.0, 20 / 255.0, 1};
  return button;
}

// One component above 1 says that all are of 0 to 255.
mjcf::Rgba blink_color(const BlinkOptions& options, const Bindings& bindings) {
  const double red = options.red.value(bindings);
  const double green = options.green.value(bindings);
  const double blue = options.blue.value(bindings);
  const double scale = std::max({red, green, blue}) > 1 ? 255.0 : 1.0;
  return {red / scale, green / scale, blue / scale, 1};
}

class BlinkCount final : public FamilyBase {
 public:
  BlinkCount(const RegistryEntry& entry, const BlinkCountParams& params)
      : FamilyBase(entry),
        params_(params),
        variables_(RandomVariables(info_.random_variables), params),
        options_(TaskOptions(info_.options)),
        red_(scene_, "button", params.button),
        black_(scene_, "confirm_button", in_black(params.button)),
        blink_lamp_(scene_, "blink_lamp"),
        phase_lamp_(scene_, "phase_lamp"),
        blinks_(params, variables_),
        expert_({.engine = engine_,
                 .info = info_,
                 .params = params_,
                 .clock = clock_,
                 .red = red_,
                 .black = black_,
                 .target = target_,
                 .press_count = press_count_,
                 .submit_attempted = submit_attempted_}),
        annotator_({.engine = engine_,
                    .clock = clock_,
                    .blinks = blinks_,
                    .red = red_,
                    .black = black_,
                    .lamp = blink_lamp_,
                    .target = target_,
                    .presses = press_count_}) {
    scene_.render_view = mjcf::RenderView::kTable;
    describe_blink_count(params, info_);
    info_.reward_terms = reward_terms_of(BlinkReward{params_});
    declare_state(*this);
    declare_sampled_values(*this);
  }

  void bind(const Bindings& bindings) override {
    FamilyBase::bind(bindings);
    clock_.bind(*bindings.memory);
    red_.bind(bindings);
    black_.bind(bindings);
    reward_dict_.bind(bindings, info_.reward_terms.size());
    blinks_.bind(*bindings.memory);
    bind_info(*bindings.outputs);
    bindings.outputs->limit("target_blinks", 0, params_.BLINK_COUNT_RANGE.high);
    blink_color_ = blink_color(options_, bindings);
  }

  int cue_end(int env) const override { return clock_.cue_end(env); }
  void sampled_values(int env, float* out) const override { write_sampled_values(*this, env, out); }
  template <class Visitor>
  void sampled_row(Visitor& row, int env) const {
    clock_.sampled_row(row, env);
    row.field("target_blinks", 1, "", "how often the lamp blinks", [&] { return target_[env]; });
  }

  // --- sampling ---

  void reset(const Episode& episode) override {
    const int env = episode.env();
    const Vec2 red(variables_.button_x.sample(episode), variables_.button_y.sample(episode));
    const Vec2 black(
        red.x(), std::clamp(red.y() + CONFIRM_BUTTON_Y_OFFSET, -kConfirmYLimit, kConfirmYLimit));
    red_.reset(env, red);
    black_.reset(env, black);
    const double x = red.x() + INDICATOR_FORWARD_OFFSET;
    const double blink_lamp[3] = {x, red.y(), INDICATOR_HEIGHT};
    const double phase_lamp[3] = {x, red.y() - PHASE_INDICATOR_X_OFFSET, INDICATOR_HEIGHT};
    blink_lamp_.place(*engine_.state, env, blink_lamp);
    phase_lamp_.place(*engine_.state, env, phase_lamp);
    target_[env] = variables_.target_blinks.sample(episode);
    clock_.reset(env, blinks_.draw(episode, target_[env]), 0);
  }

  // --- phases: the lamps show them ---

  void advance(Range envs) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      const bool lit = blinks_.lit(env, target_[env], engine_.state->elapsed[env]);
      light_on_[env] = lit ? 1 : 0;
      blink_lamp_.shine(*engine_.state, env,
                        lit ? LampLight{blink_color_, kBlinkEmission} : LampLight{kBulbGlass, 0});
      phase_lamp_.shine(*engine_.state, env,
                        {is_acting(env) ? PHASE_READY_COLOR : PHASE_WAIT_COLOR, kPhaseEmission});
      red_.follow_tool(env, true);
      black_.follow_tool(env, true);
    }
  }

  // --- success and failure: presses and their outcome ---

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

  // --- reward ---

  void dense_reward(Range envs, FloatRows out) override {
    reward_dict_.write(envs, out, [&](int env) { return measure(env); });
  }

  // --- observation ---

  void observe(Range envs, FloatRows out) override { write_state(*this, envs, out); }

  template <class Visitor>
  void state_row(Visitor& row, int env) const {
    const auto pose = [&row](const char* name, const auto& value) {
      row.field(name, 7, "m", "position, quaternion (w, x, y, z)", value);
    };
    const auto number = [&row](const char* name, const auto& value) {
      row.field(name, 1, "", "", value);
    };
    pose("button_base_pose", [&] { return red_.base_pose(env); });
    pose("button_cap_pose", [&] { return red_.cap_pose(env); });
    pose("confirm_button_base_pose", [&] { return black_.base_pose(env); });
    pose("confirm_button_cap_pose", [&] { return black_.cap_pose(env); });
    pose("indicator_pose", [&](RowWriter& out) { add_bulb_pose(env, blink_lamp_, out); });
    pose("phase_indicator_pose", [&](RowWriter& out) { add_bulb_pose(env, phase_lamp_, out); });
    number("press_count", [&] { return press_count_[env]; });
    number("target_blinks", [&] { return target_[env]; });
    number("action_mask", [&] { return action_mask_[env]; });
    number("phase_ready", [&] { return phase_ready_[env]; });
    number("press_ready", [&] { return press_ready_[env]; });
    number("pending_press", [&] { return pending_press_[env]; });
    number("submit_attempted", [&] { return submit_attempted_[env]; });
    number("submit_success", [&] { return submit_success_[env]; });
    number("at_lift_target", [&] { return at_lift_target_[env]; });
    number("oracle_info", [&] { return target_[env]; });
  }

  // --- expert ---

  const Expert& expert() const override { return expert_; }
  const Annotator* annotator() const override { return &annotator_; }

  // --- overlay ---

  void overlay(int env, Overlay& out) const override {
    out.add(OverlayText{{10, 120},
                        "Press raw/conf: " + std::to_string(raw_press_count_[env]) + "/" +
                            std::to_string(press_count_[env]) + "/" + std::to_string(target_[env]),
                        0.8});
  }

 private:
  void bind_info(ColumnStore& info) {
    submit_attempted_ = info.add<std::uint8_t>("submit_attempted");
    submit_success_ = info.add<std::uint8_t>("submit_success");
    action_mask_ = info.add<std::uint8_t>("action_mask", 1, "", "presses count");
    phase_ready_ = info.add<std::uint8_t>("phase_ready", 1, "", "the phase lamp is green");
    light_on_ = info.add<std::uint8_t>("light_on", 1, "", "the lamp is lit");
    press_count_ = info.add<std::int32_t>("press_count", 1, "", "presses that were lifted");
    raw_press_count_ = info.add<std::int32_t>("raw_press_count", 1, "", "presses that began");
    target_ = info.add_privileged<std::int32_t>("target_blinks");
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
    obj_to_goal_pos_ =
        info.add_privileged<float>("obj_to_goal_pos", 3, "m", "red cap minus TCP position");
  }

  bool is_acting(int env) const {
    return engine_.state->elapsed[env] >= clock_.manipulation_start(env);
  }

  void judge(int env, bool acting, bool submitted) const {
    const bool correct = press_count_[env] == target_[env];
    const bool too_many = raw_press_count_[env] > target_[env];
    const bool failed = engine_.failed[env] != 0 || too_many;
    if (too_many) engine_.answers.give(env, raw_press_count_[env], false);
    if (submitted) engine_.answers.give(env, press_count_[env], correct && !failed);
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

  BlinkReward measure(int env) const {
    const Eigen::Map<const Eigen::Vector3d> tcp(engine_.state->tcp_pos.row(env));
    const auto distance = [&tcp](const double* pos) {
      return (Eigen::Map<const Eigen::Vector3d>(pos) - tcp).norm();
    };
    BlinkReward in{params_};
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
    in.action_cost = measure_action_cost(engine_, env, FirstChange::kFromZero);
    return in;
  }

  void add_bulb_pose(int env, const Lamp& lamp, RowWriter& out) const {
    out.add_pose(engine_.state->prop_pos_of(env, lamp.bulb()),
                 engine_.state->prop_quat_of(env, lamp.bulb()));
  }

  BlinkCountParams params_;
  BlinkVariables variables_;
  BlinkOptions options_;
  mjcf::Rgba blink_color_{};
  PhaseClock clock_;
  PressButton red_;
  PressButton black_;
  Lamp blink_lamp_;
  Lamp phase_lamp_;
  Blinks blinks_;
  RewardDict reward_dict_;
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
  BlinkCountExpert expert_;
  BlinkCountAnnotator annotator_;
};

}  // namespace

constexpr auto kRows = rows_of(kBlinkVariants);

const Family kBlinkCountButtonPress = {
    .name = "BlinkCountButtonPress",
    .memory_type = "Temporal",
    .instruction =
        "Count how many times the blue lamp blinks, press the red button exactly that many "
        "times when the red lamp turns green, then press the black button to submit your "
        "answer.",
    .tasks = kRows,
    .make = make_variant<BlinkCount, kBlinkVariants>,
    .expectations = {.min_reward = -0.985, .max_reward = 0.425, .settles = false},
    .memory = {.answer_cut = AnswerCut::kCount,
               .irrelevant = CounterfactualChange::kDraw,
               .irrelevant_draw = "pre_blink_off_steps",
               .items = "target_blinks"}};

}  // namespace engram::tasks
