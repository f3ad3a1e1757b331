#include "tasks/rotate/task.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <optional>

#include "core/base/join.h"
#include "core/image/overlay.h"
#include "core/math/real_functions.h"
#include "mjcf/peg.h"
#include "mjcf/scene.h"
#include "tasks/common/family_base.h"
#include "tasks/common/phase_budget.h"
#include "tasks/common/random_variables.h"
#include "tasks/common/reward_dict.h"
#include "tasks/common/task_info.h"
#include "tasks/common/variant.h"
#include "tasks/rotate/annotator.h"
#include "tasks/rotate/expert.h"
#include "tasks/rotate/peg_angle.h"

namespace engram::tasks {
namespace {

// --- parameters ---

struct Params {
  TaskSpec task;
  RotateMode MODE;
  bool strict;
  double success_reward;
  int success_from = 0;           // control steps of an episode before which nothing is a success
  double angle_threshold = 0.1;   // rad
  double PEG_HALF_WIDTH = 0.025;  // m
  double PEG_HALF_LENGTH = 0.12;  // m
  // None: rewards know no action cost.
  std::optional<SmoothnessParams> smoothness = SmoothnessParams{};

  RotateTermNames term_names() const;
  // What rewards of all steps depend on.
  RotateReward reward_form() const;
  void declare(ConstantBinder& constants);
  void check(int horizon) const;
};

constexpr std::array kModeNames = {"pos_angle", "pos_neg_angle"};
constexpr int kTimeToAct = 25;  // control steps that a small turn takes

void Params::declare(ConstantBinder& constants) {
  int mode = static_cast<int>(MODE);
  constants.name("MODE", mode, kModeNames, "targets: to the left alone, or to both sides");
  MODE = static_cast<RotateMode>(mode);
  constants
      .real("angle_threshold", angle_threshold, {0.05, 0.3}, "rad",
            "error within which the peg has turned far enough; the least target, too")
      .published = false;
  constants.real("PEG_HALF_WIDTH", PEG_HALF_WIDTH, {0.015, strict ? 0.03 : 0.035}, "m",
                 "half the peg's width and height; its mass grows with it");
  constants.real("PEG_HALF_LENGTH", PEG_HALF_LENGTH, {0.06, 0.18}, "m",
                 "half the peg's length; its mass grows with it");
  if (smoothness) smoothness->declare(constants);
}

RotateTermNames Params::term_names() const {
  if (!task.is_rl()) return {"correct_angle", strict ? "y_angle_diff_deg" : "angle_diff_deg"};
  if (strict) return {"correct_angle", "y_angle_diff"};
  return {"self.correct_angle", "self.angle_diff"};
}

RotateReward Params::reward_form() const {
  return {.angle_threshold = angle_threshold,
          .smoothness = smoothness.value_or(SmoothnessParams{}),
          .success_reward = success_reward,
          .strict = strict,
          .names = term_names(),
          .lists_smoothness = smoothness.has_value()};
}

void Params::check(int horizon) const {
  check_horizon(horizon, {}, kTimeToAct);
  // A shorter one would be pushed, not turned.
  if (PEG_HALF_LENGTH >= 2 * PEG_HALF_WIDTH) return;
  refuse_constant("PEG_HALF_LENGTH", shortest(PEG_HALF_LENGTH),
                  "at least twice PEG_HALF_WIDTH = " + shortest(2 * PEG_HALF_WIDTH) + " allowed");
}

// A row of the RL tasks, which show no success in the first five steps.
constexpr Params rl_row(const TaskSpec& task, RotateMode mode, bool strict, double success_reward) {
  return {.task = task,
          .MODE = mode,
          .strict = strict,
          .success_reward = success_reward,
          .success_from = 6,
          .smoothness = std::nullopt};
}

constexpr std::array<Params, 4> kLenient = {{
    {{"RotateLenientPosNeg-VLA-v0", 60, Split::kShort}, RotateMode::kPosNegAngle, false, 60},
    {{"RotateLenientPos-VLA-v0", 60, Split::kShort}, RotateMode::kPosAngle, false, 60},
    rl_row({"RotateLenientPos-v0", 90, Split::kRl}, RotateMode::kPosAngle, false, 25),
    rl_row({"RotateLenientPosNeg-v0", 90, Split::kRl}, RotateMode::kPosNegAngle, false, 25),
}};
constexpr TaskSpec strict_rl_task(std::string_view id) {
  return {.id = id, .horizon = 90, .split = Split::kRl, .memory_type = "Object"};
}
constexpr std::array<Params, 4> kStrict = {{
    {{"RotateStrictPosNeg-VLA-v0", 90, Split::kShort}, RotateMode::kPosNegAngle, true, 100},
    {{"RotateStrictPos-VLA-v0", 90, Split::kShort}, RotateMode::kPosAngle, true, 100},
    rl_row(strict_rl_task("RotateStrictPos-v0"), RotateMode::kPosAngle, true, 100),
    rl_row(strict_rl_task("RotateStrictPosNeg-v0"), RotateMode::kPosNegAngle, true, 100),
}};

constexpr double kMaxOffset = 0.05;   // m, in x and in y, of the strict family
constexpr double kMinTurn = 0.01;     // rad in a control step: a peg that turns less rests
constexpr double kTurnedShare = 0.5;  // of the threshold: a peg that has turned less is as it was
constexpr double kStartSpan = 0.1;    // m, to either side
constexpr mjcf::Rgba kPegBlue = {12 / 255.0, 42 / 255.0, 160 / 255.0, 1};

std::string in_degrees(double angle) {
  char text[16];
  std::snprintf(text, sizeof text, "%.1f", angle * 180 / kPi);
  return text;
}

// Random variables of an episode.
struct Variables {
  Variables(RandomVariables list, const Params& params)
      : target_angle(list.add({"target_angle", 1, false, min_target(params),
                               largest_angle(params.MODE), "rad", target_description(params)})),
        initial_yaw(list.real("initial_yaw", {0, 2 * kPi}, "rad", "of the peg")),
        peg_x(list.real("peg_x", {-kStartSpan, kStartSpan}, "m", "where the peg lies")),
        peg_y(list.real("peg_y", {-kStartSpan, kStartSpan}, "m", "where the peg lies")) {}

  static double min_target(const Params& params) {
    const bool both = params.MODE == RotateMode::kPosNegAngle;
    return both ? -largest_angle(params.MODE) : params.angle_threshold;
  }

  // The two intervals of PosNeg are narrower than the values that may be pinned.
  static std::string target_description(const Params& params) {
    std::string drawn;
    if (params.MODE == RotateMode::kPosNegAngle) {
      const double least = params.angle_threshold;
      const double most = largest_angle(params.MODE);
      const double middle = (least + most) / 2;
      drawn = "drawn from " + in_degrees(-middle) + " to " + in_degrees(-least) + " or from " +
              in_degrees(middle) + " to " + in_degrees(most) + " degrees; ";
    }
    return "by which to turn the peg; " + drawn + "rounded to half precision";
  }

  VariableHandle target_angle;
  RealVariable initial_yaw;
  RealVariable peg_x;
  RealVariable peg_y;
};

// Excess of the success rate of guesses over their being right: the robot may be slow for a moment
// as the right angle goes by. Measured, over 4 x 4000 episodes.
constexpr double kOnTheWay = 0.016;

bool is_correct(double error, double threshold) { return std::abs(error) < threshold; }

// Answers between which a guess decides, as if targets were that many.
int candidates(const Params& params) {
  return static_cast<int>(std::lround(1 / guess_rate(params.MODE, params.angle_threshold)));
}

class Rotate final : public FamilyBase {
 public:
  Rotate(const RegistryEntry& entry, const Params& params)
      : FamilyBase(entry),
        params_(params),
        variables_(RandomVariables(info_.random_variables), params),
        expert_({.engine = engine_,
                 .info = info_,
                 .target = target_,
                 .initial_yaw = initial_yaw_,
                 .initial_position = initial_position_,
                 .mode = params.MODE,
                 .strict = params.strict,
                 .threshold = params.angle_threshold,
                 .peg = {params.PEG_HALF_WIDTH, params.PEG_HALF_LENGTH}}),
        annotator_({.engine = engine_,
                    .target = target_,
                    .initial_yaw = initial_yaw_,
                    .threshold = params.angle_threshold,
                    .peg_half_length = params.PEG_HALF_LENGTH}) {
    info_.candidates = candidates(params);
    info_.answer_rate = guess_rate(params.MODE, params.angle_threshold);
    info_.guess_rate = std::min(1.0, info_.answer_rate + kOnTheWay);
    info_.answer =
        "the angle by which the peg has turned when it and the robot first rest, if that is more "
        "than half of angle_threshold; in whole degrees";
    if (info_.termination == Termination::kSuccess) info_.answer += kSuccessAnswers;
    info_.success_reward = params.success_reward;
    info_.oracle_dim = 1;
    info_.oracle_is_real = true;
    info_.task_cue_dim = 1;
    info_.reward_terms = reward_terms_of(params.reward_form());
    info_.phases = {{"manipulation", "always"}};
    declare_state(*this);
    declare_sampled_values(*this);
    scene_.props = {
        mjcf::peg("peg", params.PEG_HALF_LENGTH, params.PEG_HALF_WIDTH, kPegBlue, kPegBlue)};
    scene_.render_view = mjcf::RenderView::kAboveTable;
  }

  void bind(const Bindings& bindings) override {
    FamilyBase::bind(bindings);
    ColumnStore& info = *bindings.outputs;
    const auto add_pos_error = [&](const char* name) {
      return params_.strict ? info.add<float>(name, 1, "m", "of the peg's centre")
                            : Column<float>();
    };
    relative_angle_ = info.add<float>("relative_angle", 1, "rad", "turned since the beginning");
    if (params_.task.is_rl()) x_pos_error_ = add_pos_error("x_pos_error");  // the original's order
    y_angle_error_ = info.add<float>("y_angle_error", 1, "rad", "rotation still to be done");
    if (!params_.task.is_rl()) x_pos_error_ = add_pos_error("x_pos_error");
    y_pos_error_ = add_pos_error("y_pos_error");
    reward_dict_.bind(bindings, info_.reward_terms.size());
    ColumnStore& memory = *bindings.memory;
    target_ = memory.add<double>("target_angle", 1, "rad");
    initial_yaw_ = memory.add<double>("initial_yaw", 1, "rad");
    initial_position_ = memory.add<double>("initial_peg_position", 2, "m");
    last_angle_ = memory.add<double>("last_angle", 1, "rad", "turned until the step before");
  }

  // The target is in the instruction and in task_cue all the time.
  int cue_end(int /*env*/) const override { return 0; }
  void sampled_values(int env, float* out) const override { write_sampled_values(*this, env, out); }
  template <class Visitor>
  void sampled_row(Visitor& row, int env) const {
    row.field("target_angle", 1, "rad", "by which to turn the peg", [&] { return target_[env]; });
  }

  std::string instruction(int env) const override {
    return rotate_instruction(info_.instruction, target_[env]);
  }

  // --- sampling ---

  void reset(const Episode& episode) override {
    const int env = episode.env();
    const double* pinned = variables_.target_angle.pinned(episode);
    target_[env] = pinned != nullptr ? round_to_half(*pinned)
                                     : draw_target(variables_.target_angle.stream(episode));
    const double yaw = variables_.initial_yaw.sample(episode);
    const double pos[3] = {variables_.peg_x.sample(episode), variables_.peg_y.sample(episode),
                           params_.PEG_HALF_WIDTH};
    const double quat[4] = {real::cos(yaw / 2), 0, 0, real::sin(yaw / 2)};
    initial_yaw_[env] = yaw;
    last_angle_[env] = 0;
    std::copy_n(pos, 2, initial_position_.row(env));
    engine_.state->place_prop(env, kPeg, pos, quat);
  }

  // --- phases: there is only one ---

  void advance(Range /*envs*/) override {}

  // --- success ---

  void evaluate(Range envs) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      const PegTurn turn = measure(env);
      relative_angle_[env] = static_cast<float>(turn.relative);
      y_angle_error_[env] = static_cast<float>(turn.error);
      engine_.oracle_values[env] = static_cast<float>(turn.error);
      engine_.task_cue[env] = static_cast<float>(target_[env]);
      bool in_place = true;
      if (params_.strict) {
        const Eigen::Vector2d shift = position_error(env);
        x_pos_error_[env] = static_cast<float>(shift.x());
        y_pos_error_[env] = static_cast<float>(shift.y());
        in_place = shift.cwiseAbs().maxCoeff() < kMaxOffset;
      }
      note_answer(env, turn);
      last_angle_[env] = turn.relative;
      const bool counts = engine_.state->elapsed[env] >= params_.success_from &&
                          (!engine_.strict || engine_.answers.given(env));
      const bool success = counts && is_correct(turn.error, params_.angle_threshold) && in_place &&
                           robot_is_static(*engine_.state, env);
      engine_.success[env] = success ? 1 : 0;
      // The rule of such a task ends the episode before the peg comes to rest.
      if (success && info_.termination == Termination::kSuccess && !engine_.answers.given(env)) {
        give_answer(env, turn);
      }
      reward_dict_.publish(env);
    }
  }

  // --- reward ---

  void dense_reward(Range envs, FloatRows out) override {
    reward_dict_.write(envs, out, [&](int env) {
      RotateReward reward = params_.reward_form();
      reward.distance = (prop_pos(env, kPeg) - tcp_pos(env)).norm();
      reward.error = measure(env).error;
      reward.x_pos_error = position_error(env).x();
      reward.y_pos_error = position_error(env).y();
      reward.action_cost = measure_action_cost(engine_, env);
      reward.robot_static = robot_is_static(*engine_.state, env);
      reward.success = engine_.success[env] != 0;
      return reward;
    });
  }

  // --- observation ---

  template <class Visitor>
  void state_row(Visitor& row, int env) const {
    row.field("oracle_info", 1, "rad", "rotation still to be done",
              [&] { return measure(env).error; });
    row.field("peg_pose", 7, "m", "position, quaternion (w, x, y, z)",
              [&] { return prop_pose(env, kPeg); });
  }
  void observe(Range envs, FloatRows out) override { write_state(*this, envs, out); }

  // --- expert ---

  const Expert& expert() const override { return expert_; }
  const Annotator* annotator() const override { return &annotator_; }

  // --- overlay ---

  void overlay(int env, Overlay& out) const override {
    const auto degrees = [](const char* name, double angle) {
      char text[40];
      std::snprintf(text, sizeof text, "%s: %.2f deg", name, angle * 180 / kPi);
      return std::string(text);
    };
    out.add(OverlayText{{10, 60}, degrees("Target ", target_[env])});
    out.add(OverlayText{{10, 120}, degrees("Current", measure(env).relative)});
  }

 private:
  PegTurn measure(int env) const {
    return peg_turn(peg_angle(engine_.state->prop_quat_of(env, kPeg)), initial_yaw_[env],
                    target_[env]);
  }

  void note_answer(int env, const PegTurn& turn) const {
    const State& state = *engine_.state;
    const bool turned = std::abs(turn.relative) > kTurnedShare * params_.angle_threshold;
    // A peg that is held keeps a velocity that its pose does not follow.
    const bool rests = std::abs(wrap_angle(turn.relative - last_angle_[env])) < kMinTurn;
    if (!turned || !rests || !robot_is_static(state, env)) return;
    give_answer(env, turn);
  }
  void give_answer(int env, const PegTurn& turn) const {
    engine_.answers.give(env, static_cast<int>(std::lrint(turn.relative * 180 / kPi)),
                         is_correct(turn.error, params_.angle_threshold));
  }

  Eigen::Vector2d position_error(int env) const {
    using Vec2 = Eigen::Map<const Eigen::Vector2d>;
    return Vec2(engine_.state->prop_pos_of(env, kPeg)) - Vec2(initial_position_.row(env));
  }

  double draw_target(RandomStream random) const {
    return target_angle(params_.MODE, params_.angle_threshold, random.uniform());
  }

  Params params_;
  Variables variables_;
  RewardDict reward_dict_;
  Column<float> relative_angle_;
  Column<float> y_angle_error_;
  Column<float> x_pos_error_;  // strict only, as the next
  Column<float> y_pos_error_;
  Column<double> target_;            // rad, a half-precision number
  Column<double> initial_yaw_;       // rad
  Column<double> initial_position_;  // (2) m
  Column<double> last_angle_;        // rad, turned until the step before
  RotateExpert expert_;
  RotateAnnotator annotator_;
};

}  // namespace

double RotateReward::compute() {
  smooth = tasks::smoothness(action_cost, smoothness);
  const double value = strict ? strict_value() : lenient_value();
  return success ? success_reward : value;
}

double RotateReward::lenient_value() {
  reaching = real::exp(-5 * distance);
  reached = distance < 0.1;
  rotate = real::exp(-1.5 * std::abs(error));
  double value = reaching - smooth.penalty;
  if (reached) value += 15 * rotate;
  if (is_correct()) value += 5;
  if (is_correct() && robot_static) value += 2;
  return value;
}

double RotateReward::strict_value() {
  reaching = 0.5 * real::exp(-3 * distance);
  reached = distance < 0.04;
  x_pos = real::exp(-5 * std::abs(x_pos_error));
  y_pos = real::exp(-5 * std::abs(y_pos_error));
  position_ok = std::max(std::abs(x_pos_error), std::abs(y_pos_error)) < kMaxOffset;
  rotate = real::exp(-1.0 * std::abs(error));
  double value = reaching - smooth.penalty;
  const bool at_work = reached && position_ok;
  const bool correct = at_work && is_correct();
  if (reached) value += 5 * x_pos + 5 * y_pos;
  if (at_work) value += 35 * rotate;
  if (correct) value += 10;
  if (correct && robot_static) value += 5;
  return value;
}

constexpr auto kLenientRows = rows_of(kLenient);
constexpr auto kStrictRows = rows_of(kStrict);

const Family kRotateLenient = {
    .name = "RotateLenient",
    .memory_type = "Spatial",
    .instruction = "Rotate the peg by {angle_deg} degrees to match the target angle.",
    .tasks = kLenientRows,
    .make = make_variant<Rotate, kLenient>,
    .expectations = {.min_reward = 0, .max_reward = 0.35},
    .memory = {.no_counterfactuals =
                   "the past is the pose of the peg, which the present goes on from"}};

const Family kRotateStrict = {
    .name = "RotateStrict",
    .memory_type = "Spatial",
    .instruction =
        "Rotate the peg by {angle_deg} degrees to match the target angle while keeping the "
        "center of the peg in place.",
    .tasks = kStrictRows,
    .make = make_variant<Rotate, kStrict>,
    .expectations = {.min_reward = 0, .max_reward = 0.555},
    .memory = {.no_counterfactuals =
                   "the past is the pose of the peg, which the present goes on from"}};

}  // namespace engram::tasks
