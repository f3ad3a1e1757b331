#include "tasks/rotate/task.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "core/picture/overlay.h"
#include "mjcf/peg.h"
#include "mjcf/scene.h"
#include "tasks/parts/reward_dict.h"
#include "tasks/parts/smoothness.h"
#include "tasks/parts/state_row.h"
#include "tasks/parts/task_info.h"
#include "tasks/parts/variant.h"
#include "tasks/rotate/peg_angle.h"
#include "tasks/rotate/peg_turner.h"

namespace engram::tasks {
namespace {

constexpr double kPi = std::numbers::pi;

// --- parameters (sections 3 and 4) ---

struct Params {
  std::string_view id;
  RotateMode MODE;
  bool strict;
};

constexpr std::array<Params, 4> kVariants = {{
    {"RotateLenientPos-VLA-v0", RotateMode::kPosAngle, false},
    {"RotateLenientPosNeg-VLA-v0", RotateMode::kPosNegAngle, false},
    {"RotateStrictPos-VLA-v0", RotateMode::kPosAngle, true},
    {"RotateStrictPosNeg-VLA-v0", RotateMode::kPosNegAngle, true},
}};

constexpr double kMostOffset = 0.05;  // m, in x and in y, of the strict family
constexpr double kStartSpan = 0.1;    // m, to either side
constexpr double kLenientSuccessReward = 60;
constexpr double kStrictSuccessReward = 100;
constexpr SmoothnessParams kSmoothness = {};
constexpr mjcf::Rgba kPegBlue = {12 / 255.0, 42 / 255.0, 160 / 255.0, 1};
constexpr int kPeg = 0;

enum DrawIndex { kTargetAngle, kInitialYaw, kPegX, kPegY };

std::vector<Draw> draws(RotateMode mode) {
  const bool both = mode == RotateMode::kPosNegAngle;
  return {
      {"target_angle", 1, false, both ? -kPi / 4 : kAngleThreshold, both ? kPi / 4 : kPi / 2, "rad",
       "by which to turn the peg; rounded to half precision"},
      {"initial_yaw", 1, false, 0, 2 * kPi, "rad", "of the peg"},
      {"peg_x", 1, false, -kStartSpan, kStartSpan, "m", "where the peg lies"},
      {"peg_y", 1, false, -kStartSpan, kStartSpan, "m", "where the peg lies"},
  };
}

ConstantTable constants(RotateMode mode) {
  return {{"PEG_HALF_WIDTH", PEG_HALF_WIDTH},
          {"PEG_HALF_LENGTH", PEG_HALF_LENGTH},
          {"MODE", mode == RotateMode::kPosAngle ? "pos_angle" : "pos_neg_angle"},
          {"ACTION_L2_COEF", kSmoothness.ACTION_L2_COEF},
          {"ACTION_DELTA_L2_COEF", kSmoothness.ACTION_DELTA_L2_COEF},
          {"QVEL_L2_COEF", kSmoothness.QVEL_L2_COEF}};
}

std::vector<std::string> reward_terms(bool strict) {
  if (strict) {
    return {"to_grip_dist",  "reaching_reward",  "reached_status",  "y_angle_reward",
            "correct_angle", "y_angle_diff_deg", "agent_is_static", "success",
            "x_pos_error",   "y_pos_error",      "x_pos_reward",    "y_pos_reward",
            "position_ok",   "action_l2",        "delta_action_l2", "qvel_l2",
            "smooth_penalty"};
  }
  return {"to_grip_dist",  "reaching_reward", "reached_status",  "y_angle_reward",
          "correct_angle", "angle_diff_deg",  "agent_is_static", "success",
          "action_l2",     "delta_action_l2", "qvel_l2",         "smooth_penalty"};
}

// Answers between which a guess decides: targets that are one threshold's width apart.
int candidates(RotateMode mode) { return mode == RotateMode::kPosAngle ? 8 : 4; }

class Rotate final : public Task {
 public:
  Rotate(const RegistryEntry& entry, const Params& params) : params_(params) {
    info_ = describe(entry);
    info_.termination = Termination::kNever;
    info_.candidates = candidates(params.MODE);
    info_.success_reward = params.strict ? kStrictSuccessReward : kLenientSuccessReward;
    info_.oracle_dim = 1;
    info_.oracle_is_real = true;
    info_.task_cue_dim = 1;
    info_.draws = draws(params.MODE);
    info_.constants = constants(params.MODE);
    info_.reward_terms = reward_terms(params.strict);
    info_.phases = {{"manipulation", "always"}};
    info_.state_fields = {
        {"oracle_info", 1, DType::kFloat32, "rad", "rotation still to be done"},
        {"peg_pose", 7, DType::kFloat32, "m", "position, quaternion (w, x, y, z)"}};
    scene_.props = {mjcf::peg("peg", PEG_HALF_LENGTH, PEG_HALF_WIDTH, kPegBlue, kPegBlue)};
    scene_.render_camera = mjcf::RenderCamera::kC;
  }

  const TaskInfo& info() const override { return info_; }
  SceneSource scene() const override { return scene_source(scene_); }
  std::string document() const override { return mjcf::compose(scene_, mjcf::Detail::kFull); }

  void bind(const Bindings& bindings) override {
    engine_ = bindings;
    ColumnStore& info = *bindings.outputs;
    relative_angle_ = info.add<float>("relative_angle", 1, "rad", "turned since the beginning");
    y_angle_error_ = info.add<float>("y_angle_error", 1, "rad", "rotation still to be done");
    if (params_.strict) {
      x_pos_error_ = info.add<float>("x_pos_error", 1, "m", "of the peg's centre");
      y_pos_error_ = info.add<float>("y_pos_error", 1, "m", "of the peg's centre");
    }
    reward_dict_.bind(bindings, static_cast<int>(info_.reward_terms.size()));
    ColumnStore& memory = *bindings.memory;
    target_ = memory.add<double>("target_angle", 1, "rad");
    initial_yaw_ = memory.add<double>("initial_yaw", 1, "rad");
    initial_position_ = memory.add<double>("initial_peg_position", 2, "m");
  }

  // The target is in the instruction and in task_cue all the time.
  int cue_end(int /*env*/) const override { return 0; }

  std::string instruction(int env) const override {
    return rotate_instruction(info_.instruction, target_[env]);
  }

  // --- sampling (sections 3.2 and 4.1) ---

  void reset(const Episode& episode) override {
    const int env = episode.env();
    const double* pinned = episode.pinned(kTargetAngle);
    target_[env] = pinned != nullptr
                       ? round_to_half(*pinned)
                       : target_angle(params_.MODE, episode.stream(kTargetAngle).uniform());
    const double yaw = episode.real(kInitialYaw, 0, 2 * kPi);
    const double pos[3] = {episode.real(kPegX, -kStartSpan, kStartSpan),
                           episode.real(kPegY, -kStartSpan, kStartSpan), PEG_HALF_WIDTH};
    const double quat[4] = {std::cos(yaw / 2), 0, 0, std::sin(yaw / 2)};
    initial_yaw_[env] = yaw;
    std::copy_n(pos, 2, initial_position_.row(env));
    engine_.state->place_prop(env, kPeg, pos, quat);
  }

  void advance(Range /*envs*/) override {}

  // --- success (sections 3.5 and 4.2) ---

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
        in_place = shift.cwiseAbs().maxCoeff() < kMostOffset;
      }
      const bool correct = std::abs(turn.error) < kAngleThreshold;
      engine_.success[env] = correct && in_place && robot_is_static(*engine_.state, env) ? 1 : 0;
      reward_dict_.publish(env);
    }
  }

  // --- reward (sections 3.7 and 4.3) ---

  void dense_reward(Range envs, FloatRows out) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      const State& state = *engine_.state;
      const Haste haste = measure_haste(engine_, env);
      const SmoothnessTerms smooth = smoothness(haste, kSmoothness);
      RotateRewardInputs in;
      in.distance = (Eigen::Map<const Eigen::Vector3d>(state.prop_pos_of(env, kPeg)) -
                     Eigen::Map<const Eigen::Vector3d>(state.tcp_pos.row(env)))
                        .norm();
      in.error = measure(env).error;
      in.x_pos_error = position_error(env).x();
      in.y_pos_error = position_error(env).y();
      in.penalty = smooth.penalty;
      in.robot_static = robot_is_static(state, env);
      in.success = engine_.success[env] != 0;
      const RotateRewardTerms terms =
          params_.strict ? rotate_strict_reward(in) : rotate_lenient_reward(in);
      note_terms(env, in, terms, smooth);
      *out.row(env) = static_cast<float>(terms.reward);
    }
  }

  // --- observation (sections 3.5 and 4.2) ---

  void observe(Range envs, FloatRows out) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      RowWriter row(out.row(env));
      row.add(measure(env).error);
      row.add(engine_.state->prop_pos_of(env, kPeg), 3);
      row.add(engine_.state->prop_quat_of(env, kPeg), 4);
    }
  }

  // --- oracle (sections 3.8 and 4.6) ---

  void act(Range envs, bool blind, FloatRows actions) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      const double target = blind ? guess(env) : target_[env];
      const double angle = peg_angle(engine_.state->prop_quat_of(env, kPeg));
      const PegGoal goal{peg_turn(angle, initial_yaw_[env], target).error,
                         initial_position_.row(env)[0], initial_position_.row(env)[1]};
      if (params_.strict) {
        twist_peg(*engine_.state, env, goal, actions.row(env));
      } else {
        push_peg(*engine_.state, env, goal, actions.row(env));
      }
    }
  }

  // --- overlay (common 11) ---

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

  Eigen::Vector2d position_error(int env) const {
    using Vec2 = Eigen::Map<const Eigen::Vector2d>;
    return Vec2(engine_.state->prop_pos_of(env, kPeg)) - Vec2(initial_position_.row(env));
  }

  // What an agent that has not read the target would turn.
  double guess(int env) const {
    const State& state = *engine_.state;
    RandomStream random(state.seed[env], state.episode[env], kPurposeBlindGuess);
    return target_angle(params_.MODE, random.uniform());
  }

  void note_terms(int env, const RotateRewardInputs& in, const RotateRewardTerms& terms,
                  const SmoothnessTerms& smooth) const {
    const auto flag = [](bool value) { return value ? 1.0 : 0.0; };
    const double degrees = in.error * 180 / kPi;
    const double correct = flag(std::abs(in.error) < kAngleThreshold);
    if (params_.strict) {
      reward_dict_.note<17>(
          env, {in.distance, terms.reaching, flag(terms.reached), terms.rotate, correct, degrees,
                flag(in.robot_static), flag(in.success), in.x_pos_error, in.y_pos_error,
                terms.x_pos, terms.y_pos, flag(terms.position_ok), smooth.action_l2,
                smooth.action_delta_l2, smooth.qvel_l2, smooth.penalty});
    } else {
      reward_dict_.note<12>(
          env, {in.distance, terms.reaching, flag(terms.reached), terms.rotate, correct, degrees,
                flag(in.robot_static), flag(in.success), smooth.action_l2, smooth.action_delta_l2,
                smooth.qvel_l2, smooth.penalty});
    }
  }

  Params params_;
  TaskInfo info_;
  mjcf::Scene scene_;
  Bindings engine_;
  RewardDict reward_dict_;
  Column<float> relative_angle_;
  Column<float> y_angle_error_;
  Column<float> x_pos_error_;  // strict only, as the next
  Column<float> y_pos_error_;
  Column<double> target_;            // rad, a half-precision number
  Column<double> initial_yaw_;       // rad
  Column<double> initial_position_;  // (2) m
};

}  // namespace

RotateRewardTerms rotate_lenient_reward(const RotateRewardInputs& in) {
  const double error = std::abs(in.error);
  const bool correct = error < kAngleThreshold;
  RotateRewardTerms terms;
  terms.reaching = std::exp(-5 * in.distance);
  terms.reached = in.distance < 0.1;
  terms.rotate = std::exp(-1.5 * error);
  terms.reward = terms.reaching - in.penalty;
  if (terms.reached) terms.reward += 15 * terms.rotate;
  if (correct) terms.reward += 5;
  if (correct && in.robot_static) terms.reward += 2;
  if (in.success) terms.reward = kLenientSuccessReward;
  return terms;
}

RotateRewardTerms rotate_strict_reward(const RotateRewardInputs& in) {
  const double error = std::abs(in.error);
  RotateRewardTerms terms;
  terms.reaching = 0.5 * std::exp(-3 * in.distance);
  terms.reached = in.distance < 0.04;
  terms.x_pos = std::exp(-5 * std::abs(in.x_pos_error));
  terms.y_pos = std::exp(-5 * std::abs(in.y_pos_error));
  terms.position_ok = std::max(std::abs(in.x_pos_error), std::abs(in.y_pos_error)) < kMostOffset;
  terms.rotate = std::exp(-1.0 * error);
  terms.reward = terms.reaching - in.penalty;
  const bool at_work = terms.reached && terms.position_ok;
  const bool correct = at_work && error < kAngleThreshold;
  if (terms.reached) terms.reward += 5 * terms.x_pos + 5 * terms.y_pos;
  if (at_work) terms.reward += 35 * terms.rotate;
  if (correct) terms.reward += 10;
  if (correct && in.robot_static) terms.reward += 5;
  if (in.success) terms.reward = kStrictSuccessReward;
  return terms;
}

std::unique_ptr<Task> make_rotate(const RegistryEntry& entry) {
  return std::make_unique<Rotate>(entry, find_variant(kVariants, entry.id));
}

}  // namespace engram::tasks
