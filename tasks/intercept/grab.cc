#include "tasks/intercept/grab.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "mjcf/scene.h"
#include "tasks/intercept/ball_catcher.h"
#include "tasks/intercept/ball_launch.h"
#include "tasks/parts/reward_dict.h"
#include "tasks/parts/task_info.h"
#include "tasks/parts/tool_servo.h"
#include "tasks/parts/variant.h"

namespace engram::tasks {
namespace {

using Vector = Eigen::Vector3d;

// --- parameters (section 2) ---

struct Params {
  std::string_view id;
  VelocityRange VELOCITY_RANGE;  // m/s
};

constexpr std::array<Params, 3> kVariants = {{
    {"InterceptGrabSlow-VLA-v0", {0.25, 0.5}},
    {"InterceptGrabMedium-VLA-v0", {0.5, 0.75}},
    {"InterceptGrabFast-VLA-v0", {0.75, 1.0}},
}};

constexpr double kSuccessReward = 300;

ConstantTable constants(const Params& params) {
  return {{"BALL_RADIUS", BALL_RADIUS},
          {"ACTION_L2_COEF", 0.0},
          {"ACTION_DELTA_L2_COEF", 0.0},
          {"QVEL_L2_COEF", 0.0},
          {"VELOCITY_RANGE", params.VELOCITY_RANGE.constant()}};
}

std::vector<Field> state_fields() {
  constexpr DType kFloat = DType::kFloat32;
  return {{"ball_pose", 7, kFloat, "m", "position, quaternion (w, x, y, z)"},
          {"oracle_info", 3, kFloat, "m/s", "initial velocity of the ball"},
          {"is_ball_grasped", 1, kFloat, "", ""},
          {"ball_linear_vel", 3, kFloat, "m/s", ""},
          {"ball_angular_vel", 3, kFloat, "rad/s", "about the world's axes"},
          {"tcp_to_ball_pos", 3, kFloat, "m", ""},
          {"gripper_width", 1, kFloat, "m", "sum of both finger positions"},
          {"relative_velocity", 3, kFloat, "m/s", "of the ball, as seen from the TCP"}};
}

constexpr int kRewardTerms = 11;

class InterceptGrab final : public Task {
 public:
  InterceptGrab(const RegistryEntry& entry, const Params& params)
      : launch_(params.VELOCITY_RANGE, BALL_RADIUS) {
    info_ = describe(entry);
    info_.termination = Termination::kNever;
    info_.success_reward = kSuccessReward;
    info_.oracle_dim = 3;
    info_.oracle_is_real = true;
    info_.draws = ball_draws(params.VELOCITY_RANGE);
    info_.constants = constants(params);
    info_.reward_terms = {"tcp_to_obj_dist",
                          "is_grasped_reward",
                          "ball_in_gripper",
                          "dist_tcp_to_ball_x",
                          "dist_tcp_to_ball_y",
                          "dist_tcp_to_ball_z",
                          "current_gripper_width",
                          "very_close_mask",
                          "static_reward",
                          "robot_static_reward",
                          "success"};
    info_.phases = {{"manipulation", "always"}};
    info_.state_fields = state_fields();
    scene_.props = {launched_ball()};
    scene_.table_ends = true;
  }

  const TaskInfo& info() const override { return info_; }
  SceneSource scene() const override { return scene_source(scene_); }
  std::string document() const override { return mjcf::compose(scene_, mjcf::Detail::kFull); }

  void bind(const Bindings& bindings) override {
    engine_ = bindings;
    launch_.bind(bindings);
    reward_dict_.bind(bindings, kRewardTerms);
    is_ball_grasped_ = bindings.outputs->add<std::uint8_t>("is_ball_grasped");
    is_robot_static_ = bindings.outputs->add<std::uint8_t>("is_robot_static");
  }

  // Nothing is hidden at any time.
  int cue_end(int /*env*/) const override { return 0; }

  // --- sampling (section 2.2) ---

  void reset(const Episode& episode) override { launch_.reset(episode); }

  void advance(Range /*envs*/) override {}

  // --- success and reward (sections 2.3 and 2.4) ---

  void evaluate(Range envs) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      const State& state = *engine_.state;
      launch_.tell_velocity(env);
      is_ball_grasped_[env] = is_grasping(state, env, kBallProp) ? 1 : 0;
      is_robot_static_[env] = robot_is_static(state, env) ? 1 : 0;
      engine_.success[env] = is_ball_grasped_[env] & is_robot_static_[env];
      reward_dict_.publish(env);
    }
  }

  void dense_reward(Range envs, FloatRows out) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      const GrabRewardInputs inputs{launch_.ball(env), launch_.tcp(env), gripper_width(env),
                                    is_ball_grasped_[env] != 0, engine_.success[env] != 0};
      const GrabRewardTerms terms = grab_reward(inputs);
      note_terms(env, inputs, terms);
      *out.row(env) = static_cast<float>(terms.reward);
    }
  }

  // --- observation (section 2.3) ---

  void observe(Range envs, FloatRows out) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      RowWriter row(out.row(env));
      launch_.observe_pose(env, row);
      row.add(launch_.initial_velocity(env));
      row.add(is_ball_grasped_[env]);
      row.add(launch_.linear_velocity(env));
      row.add(launch_.angular_velocity(env));
      row.add(launch_.ball(env) - launch_.tcp(env));
      row.add(gripper_width(env));
      row.add(launch_.linear_velocity(env) - tcp_velocity(env));
    }
  }

  // --- oracle (section 2.5): catch the ball and stop ---

  void act(Range envs, bool /*blind*/, FloatRows actions) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      float* action = actions.row(env);
      if (holds_ball(*engine_.state, env)) {
        hold_tool(kGripperSqueezing, action);
      } else {
        catch_ball(*engine_.state, env, action);
      }
    }
  }

 private:
  double gripper_width(int env) const {
    const double* fingers = engine_.state->qpos.row(env) + kArmJoints;
    return fingers[0] + fingers[1];
  }

  Vector tcp_velocity(int env) const {
    ArmJacobian jacobian;
    engine_.arm->forward(engine_.state->qpos.row(env), jacobian);
    return jacobian.topRows<3>() * Eigen::Map<const ArmVector>(engine_.state->qvel.row(env));
  }

  void note_terms(int env, const GrabRewardInputs& in, const GrabRewardTerms& terms) const {
    const Vector offset = (in.ball - in.tcp).cwiseAbs();
    const double spin = launch_.angular_velocity(env).norm();
    const double still = 1 - std::tanh(10 * launch_.linear_velocity(env).norm() + spin);
    const double arm_speed = Eigen::Map<const ArmVector>(engine_.state->qvel.row(env)).norm();
    const auto flag = [](bool value) { return value ? 1.0 : 0.0; };
    reward_dict_.note<kRewardTerms>(
        env, {terms.distance, flag(in.grasped), flag(terms.in_gripper), offset.x(), offset.y(),
              offset.z(), in.gripper_width, flag(terms.very_close), still,
              1 - std::tanh(5 * arm_speed), flag(in.success)});
  }

  TaskInfo info_;
  mjcf::Scene scene_;
  Bindings engine_;
  BallLaunch launch_;
  RewardDict reward_dict_;
  Column<std::uint8_t> is_ball_grasped_;
  Column<std::uint8_t> is_robot_static_;
};

}  // namespace

GrabRewardTerms grab_reward(const GrabRewardInputs& in) {
  GrabRewardTerms terms;
  const Vector offset = (in.ball - in.tcp).cwiseAbs();
  const double width = in.gripper_width;
  terms.distance = offset.norm();
  terms.in_gripper = offset.x() <= 0.04 && offset.y() <= 0.04 && offset.z() <= 0.03 &&
                     terms.distance <= 0.04 && width >= 0.04;
  terms.very_close = terms.distance <= 0.025;

  double reward = 10 * (1 - std::tanh(3 * terms.distance));
  if (terms.in_gripper) {
    reward += 10 + 90 * std::exp(-5 * std::max(std::abs(width - 0.04) - 0.02, 0.0));
    if (width <= 0.06) reward += 90;
  }
  if (terms.very_close) reward += 30 * (1 - terms.distance / 0.06);
  if (in.grasped) reward += 200;
  terms.reward = in.success ? kSuccessReward : reward;
  return terms;
}

std::unique_ptr<Task> make_intercept_grab(const RegistryEntry& entry) {
  return std::make_unique<InterceptGrab>(entry, find_variant(kVariants, entry.id));
}

}  // namespace engram::tasks
