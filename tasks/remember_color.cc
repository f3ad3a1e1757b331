#include "tasks/remember_color.h"

#include <algorithm>
#include <array>

#include "core/error.h"
#include "core/overlay.h"
#include "mjcf/scene.h"
#include "tasks/colors.h"
#include "tasks/layout.h"
#include "tasks/overlap_guard.h"
#include "tasks/phase_clock.h"
#include "tasks/task_info.h"
#include "tasks/tool_servo.h"
#include "tasks/touch_target.h"

namespace engram::tasks {
namespace {

// --- parameters (section 2) ---

struct Params {
  std::string_view id;
  int COLORS;
  StepRange CUE_PHASE_STEPS;
  StepRange EMPTY_PHASE_STEPS;
};

constexpr std::array<Params, 6> kVariants = {{
    {"RememberColor3-VLA-v0", 3, {1, 5}, {1, 5}},
    {"RememberColor5-VLA-v0", 5, {1, 5}, {1, 5}},
    {"RememberColor9-VLA-v0", 9, {1, 5}, {1, 5}},
    {"RememberColor3-Long-VLA-v0", 3, {10, 100}, {50, 450}},
    {"RememberColor5-Long-VLA-v0", 5, {100, 100}, {50, 450}},
    {"RememberColor9-Long-VLA-v0", 9, {100, 100}, {50, 450}},
}};

constexpr double CUBE_HALFSIZE = 0.02;  // m
constexpr double kRestingHeight = CUBE_HALFSIZE;
constexpr double kHiddenHeight = 1000;  // reported while a cube is hidden
constexpr double kUpright[4] = {1, 0, 0, 0};
constexpr SmoothnessParams kSmoothness = {
    .ACTION_L2_COEF = 0.02, .ACTION_DELTA_L2_COEF = 0.05, .QVEL_L2_COEF = 0.01};
constexpr SpreadParams kSpread;

// What an episode samples (section 6.1).
enum DrawIndex { kTarget, kPositions, kCueSteps, kEmptySteps };

std::vector<Draw> draws(const Params& params) {
  const auto steps = [](const char* name, StepRange range, const char* what) {
    return Draw{name,
                1,
                true,
                static_cast<double>(range.low),
                static_cast<double>(range.high),
                "control steps",
                what};
  };
  return {
      {"target", 1, true, 0, params.COLORS - 1.0, "", "colour key of the cube to touch"},
      {"positions", 2 * params.COLORS, false, -0.5, 0.5, "m",
       "x, y of every cube in the manipulation phase"},
      steps("cue_steps", params.CUE_PHASE_STEPS, "length of the cue phase"),
      steps("empty_steps", params.EMPTY_PHASE_STEPS, "length of the empty phase"),
  };
}

ConstantTable constants(const Params& params) {
  return {
      {"COLORS", params.COLORS},
      {"COLOR_MAPPING", color_mapping_constant()},
      {"GOAL_THRESH", GOAL_THRESH},
      {"CUBE_HALFSIZE", CUBE_HALFSIZE},
      {"CUE_PHASE_STEPS", params.CUE_PHASE_STEPS.constant()},
      {"EMPTY_PHASE_STEPS", params.EMPTY_PHASE_STEPS.constant()},
      {"MANIP_MIN_CUBE_DISTANCE", kSpread.MANIP_MIN_DISTANCE},
      {"MANIP_WIDTH_AXIS", kSpread.MANIP_WIDTH_AXIS},
      {"MANIP_WIDTH_SCALE", kSpread.MANIP_WIDTH_SCALE},
      {"MANIP_WIDTH_CLAMP", kSpread.MANIP_WIDTH_CLAMP},
      {"ACTION_L2_COEF", kSmoothness.ACTION_L2_COEF},
      {"ACTION_DELTA_L2_COEF", kSmoothness.ACTION_DELTA_L2_COEF},
      {"QVEL_L2_COEF", kSmoothness.QVEL_L2_COEF},
  };
}

std::vector<Field> state_fields(int cubes) {
  std::vector<Field> fields = {{"oracle_info", 1, DType::kFloat32, "", "colour key to touch"}};
  for (int key = 0; key < cubes; ++key) {
    fields.push_back({"goal_" + std::to_string(key) + "_pose", 3, DType::kFloat32, "m",
                      "position of this cube if it is the target, else zeros"});
  }
  return fields;
}

class RememberColor final : public Task {
 public:
  RememberColor(const RegistryEntry& entry, const Params& params)
      : params_(params), slots_(nominal_slots(params.COLORS)), touch_(kSmoothness) {
    info_ = describe(entry);
    info_.candidates = params.COLORS;
    info_.termination = Termination::kNever;
    // The canonical chain freezes the short ids only (section 8.1).
    info_.frozen_cue = entry.split == Split::kShort;
    info_.success_reward = kTouchSuccessReward;
    info_.oracle_dim = 1;
    info_.draws = draws(params);
    info_.hidden_draw = "target";
    info_.constants = constants(params);
    info_.reward_terms = TouchTarget::reward_term_names();
    info_.phases = cue_empty_manipulation_phases();
    info_.state_fields = state_fields(params.COLORS);
    for (int key = 0; key < params.COLORS; ++key) {
      const NamedColor& color = COLOR_MAPPING[static_cast<std::size_t>(key)];
      mjcf::Prop cube =
          mjcf::cube("cube_" + std::to_string(key), CUBE_HALFSIZE, to_rgba(color.rgba));
      const Vec2& slot = slots_[static_cast<std::size_t>(key)];
      cube.pos = {slot.x(), slot.y(), kRestingHeight};
      scene_.props.push_back(std::move(cube));
    }
  }

  const TaskInfo& info() const override { return info_; }
  SceneSource scene() const override { return scene_source(scene_); }
  std::string document() const override { return mjcf::compose(scene_, mjcf::Detail::kFull); }

  void bind(const Bindings& bindings) override {
    engine_ = bindings;
    clock_.bind(*bindings.memory);
    touch_.bind(bindings);
    target_ = bindings.memory->add<std::int32_t>("target");
    positions_ = bindings.memory->add<double>("positions", 3 * params_.COLORS, "m");
  }

  int cue_end(int env) const override { return clock_.cue_end(env); }

  // --- sampling (section 6) ---

  void reset(const Episode& episode) override {
    const int env = episode.env();
    target_[env] = episode.integer(kTarget, 0, params_.COLORS - 1);
    const Layout layout = draw_layout(episode);
    for (int key = 0; key < params_.COLORS; ++key) {
      const Vec2& point = layout[static_cast<std::size_t>(key)];
      double* pos = position(env, key);
      pos[0] = point.x();
      pos[1] = point.y();
      pos[2] = kRestingHeight;
      engine_.state->hide_prop(env, key, pos);
    }
    const auto steps = [&episode](int draw, StepRange range) {
      return episode.integer(draw, range.low, range.high);
    };
    clock_.reset(env, steps(kCueSteps, params_.CUE_PHASE_STEPS),
                 steps(kEmptySteps, params_.EMPTY_PHASE_STEPS));
    if (info_.frozen_cue) engine_.freeze_steps[env] = clock_.manipulation_start(env);
  }

  // --- phases (section 8.2) ---

  void advance(Range envs) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      const int elapsed = engine_.state->elapsed[env];
      const Phase phase = clock_.phase(env, elapsed);
      const bool begins = clock_.begins(env, elapsed);
      if (phase == Phase::kCue) show_cue(env, begins);
      if (phase == Phase::kEmpty && begins) hide_all(env);
      if (phase == Phase::kManipulation && begins) show_all(env);
    }
  }

  // --- success and reward (sections 9 and 10) ---

  void evaluate(Range envs) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      engine_.oracle_info[env] = target_[env];
      touch_.evaluate(env, target_pos(env), is_manipulation(env));
    }
  }

  void dense_reward(Range envs, FloatRows out) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      *out.row(env) = static_cast<float>(touch_.dense_reward(env));
    }
  }

  // --- observation (section 9) ---

  void observe(Range envs, FloatRows out) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      float* row = out.row(env);
      std::fill_n(row, 1 + 3 * params_.COLORS, 0.0F);
      row[0] = static_cast<float>(target_[env]);
      float* goal = row + 1 + 3 * target_[env];
      for (int i = 0; i < 3; ++i) goal[i] = static_cast<float>(target_pos(env)[i]);
    }
  }

  // --- oracle (section 11) ---

  void act(Range envs, bool blind, FloatRows actions) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      const State& state = *engine_.state;
      float* action = actions.row(env);
      const int key = blind ? guess(env) : target_[env];
      const Eigen::Vector3d touch =
          Eigen::Map<const Eigen::Vector3d>(position(env, key)) + Eigen::Vector3d(0, 0, kTouchGap);
      const Eigen::Map<const Eigen::Vector3d> tcp(state.tcp_pos.row(env));
      if (!is_manipulation(env) || (tcp - touch).norm() < kCloseEnough) {
        hold_tool(kGripperClosed, action);
      } else {
        servo_tool(state, env, approach_from_above(state, env, touch, kTravelGap), kToolDown,
                   kGripperClosed, action);
      }
    }
  }

  // --- overlay (common 11) ---

  void overlay(int env, Overlay& out) const override {
    const auto& rgba = COLOR_MAPPING[static_cast<std::size_t>(target_[env])].rgba;
    const auto byte = [&rgba](std::size_t i) { return static_cast<std::uint8_t>(rgba[i]); };
    out.add(OverlayText{{10, 60}, "Target:"});
    out.add(OverlaySwatch{{kSwatchLeft, 38}, 22, {byte(0), byte(1), byte(2)}});
  }

 private:
  static constexpr double kSwatchLeft = 130;     // right of "Target:"
  static constexpr double kTouchGap = 0.034;     // m above the cube's origin
  static constexpr double kTravelGap = 0.06;     // m more while on the way
  static constexpr double kCloseEnough = 0.010;  // m

  double* position(int env, int key) const { return positions_.row(env) + 3 * key; }
  const double* target_pos(int env) const { return engine_.state->prop_pos_of(env, target_[env]); }
  bool is_manipulation(int env) const {
    return clock_.phase(env, engine_.state->elapsed[env]) == Phase::kManipulation;
  }

  Layout draw_layout(const Episode& episode) const {
    if (const double* pinned = episode.pinned(kPositions)) {
      Layout layout;
      for (int key = 0; key < params_.COLORS; ++key) {
        layout.push_back({pinned[2 * key], pinned[2 * key + 1]});
      }
      return layout;
    }
    RandomStream random = episode.stream(kPositions);
    const auto draw = [&] {
      Layout layout = assign_slots(jitter_slots(slots_, random), random);
      if (params_.COLORS == 3) spread_and_stretch(layout, kSpread, random);
      return layout;
    };
    return draw_clear_layout(draw, [](std::size_t, std::size_t, const Vec2& offset) {
      return square_clearance(CUBE_HALFSIZE, offset);
    });
  }

  // Only the target, pinned at the origin.
  void show_cue(int env, bool begins) const {
    if (begins) hide_all(env);
    static constexpr double kCenter[3] = {0, 0, kRestingHeight};
    engine_.state->place_prop(env, target_[env], kCenter, kUpright);
  }

  // Nothing on the table; during the empty phase the target is reported above the origin, the
  // others above where they will stand.
  void hide_all(int env) const {
    for (int key = 0; key < params_.COLORS; ++key) {
      double pos[3] = {position(env, key)[0], position(env, key)[1], kHiddenHeight};
      if (key == target_[env]) pos[0] = pos[1] = 0;
      engine_.state->hide_prop(env, key, pos);
    }
  }

  void show_all(int env) const {
    for (int key = 0; key < params_.COLORS; ++key) {
      engine_.state->place_prop(env, key, position(env, key), kUpright);
    }
  }

  // What an agent without memory would touch.
  int guess(int env) const {
    const State& state = *engine_.state;
    RandomStream random(state.seed[env], state.episode[env], kPurposeBlindGuess);
    return random.integer(0, params_.COLORS - 1);
  }

  Params params_;
  TaskInfo info_;
  mjcf::Scene scene_;
  Layout slots_;
  Bindings engine_;
  PhaseClock clock_;
  TouchTarget touch_;
  Column<std::int32_t> target_;
  Column<double> positions_;  // (COLORS * 3) m: the manipulation layout
};

}  // namespace

std::unique_ptr<Task> make_remember_color(const RegistryEntry& entry) {
  const auto found = std::find_if(kVariants.begin(), kVariants.end(),
                                  [&entry](const Params& params) { return params.id == entry.id; });
  if (found == kVariants.end()) {
    throw Error(Error::kInternal, "no RememberColor variant for " + std::string(entry.id));
  }
  return std::make_unique<RememberColor>(entry, *found);
}

}  // namespace engram::tasks
