#include "tasks/intercept/grab.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/math/real_functions.h"
#include "tasks/common/family_base.h"
#include "tasks/common/reward_dict.h"
#include "tasks/common/variant.h"
#include "tasks/intercept/annotator.h"
#include "tasks/intercept/ball_launch.h"
#include "tasks/intercept/expert.h"

namespace engram::tasks {
namespace {

using Vector = Eigen::Vector3d;

// --- parameters ---

struct Params {
  TaskSpec task;
  BallParams ball;
  GrabBonuses bonuses = {};

  void declare(ConstantBinder& constants) { ball.declare(constants); }
  void check(int horizon) const { ball.check(horizon); }
};

constexpr GrabBonuses kRlBonuses = {.attempt = 45, .grasp = 100};

constexpr std::array<Params, 6> kVariants = {{
    {{"InterceptGrabFast-VLA-v0", 60, Split::kShort, 0.70}, {{0.75, 1.0}}},
    {{"InterceptGrabMedium-VLA-v0", 60, Split::kShort, 0.80}, {{0.5, 0.75}}},
    {{"InterceptGrabSlow-VLA-v0", 60, Split::kShort, 0.90}, {{0.25, 0.5}}},
    {{"InterceptGrabSlow-v0", 90, Split::kRl}, rl_ball(0.25, 0.5), kRlBonuses},
    {{"InterceptGrabMedium-v0", 90, Split::kRl}, rl_ball(0.5, 0.75), kRlBonuses},
    {{"InterceptGrabFast-v0", 90, Split::kRl}, rl_ball(0.75, 1.0), kRlBonuses},
}};

constexpr double kSuccessReward = 300;

template <class Visitor>
void list_terms(Visitor& row, const GrabRewardInputs& in, const GrabRewardTerms& terms) {
  row.term("tcp_to_obj_dist", "m", terms.distance);
  row.term("is_grasped_reward", "", in.grasped);
  row.term("ball_in_gripper", "", terms.in_gripper);
  row.term("dist_tcp_to_ball_x", "m", terms.offset.x());
  row.term("dist_tcp_to_ball_y", "m", terms.offset.y());
  row.term("dist_tcp_to_ball_z", "m", terms.offset.z());
  row.term("current_gripper_width", "m", in.gripper_width);
  row.term("very_close_mask", "", terms.very_close);
  row.term("static_reward", "", terms.ball_stillness);
  row.term("robot_static_reward", "", in.robot_static);
  row.term("success", "", in.success);
}

class InterceptGrab final : public FamilyBase {
 public:
  InterceptGrab(const RegistryEntry& entry, const Params& params)
      : FamilyBase(entry),
        params_(params),
        launch_({RandomVariables(info_.random_variables), params.ball}, params.ball.BALL_RADIUS),
        expert_(engine_, params.ball),
        annotator_(engine_, InterceptGoal::kGrab) {
    describe_launch(info_);
    info_.success_reward = kSuccessReward;
    info_.reward_terms = reward_terms_of([](auto& row) { list_terms(row, {}, {}); });
    declare_state(*this);
    declare_sampled_values(*this);
    scene_.props = {launched_ball(params.ball.BALL_RADIUS)};
    scene_.table_ends = true;
  }

  void bind(const Bindings& bindings) override {
    FamilyBase::bind(bindings);
    launch_.bind(bindings);
    reward_dict_.bind(bindings, info_.reward_terms.size());
    is_ball_grasped_ = bindings.outputs->add<std::uint8_t>("is_ball_grasped");
    is_robot_static_ = bindings.outputs->add<std::uint8_t>("is_robot_static");
  }

  // --- sampling ---

  void reset(const Episode& episode) override { launch_.reset(episode); }

  // --- phases: none, and nothing is hidden at any time ---

  void advance(Range /*envs*/) override {}
  int cue_end(int /*env*/) const override { return 0; }
  void sampled_values(int env, float* out) const override { write_sampled_values(*this, env, out); }
  template <class Visitor>
  void sampled_row(Visitor& row, int env) const {
    row.field("initial_velocity", 3, "m/s", "of the ball",
              [&] { return launch_.initial_velocity(env); });
  }

  // --- success ---

  void evaluate(Range envs) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      const State& state = *engine_.state;
      launch_.publish_velocity(env);
      is_ball_grasped_[env] = is_grasping(state, env, kBallProp) ? 1 : 0;
      is_robot_static_[env] = robot_is_static(state, env) ? 1 : 0;
      engine_.success[env] = is_ball_grasped_[env] & is_robot_static_[env];
      reward_dict_.publish(env);
    }
  }

  // --- reward ---

  void dense_reward(Range envs, FloatRows out) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      GrabRewardInputs in;
      in.ball = launch_.ball(env);
      in.tcp = launch_.tcp(env);
      in.gripper_width = gripper_width(env);
      in.grasped = is_ball_grasped_[env] != 0;
      in.success = engine_.success[env] != 0;
      in.ball_radius = params_.ball.BALL_RADIUS;
      in.penalty = params_.ball.penalty(engine_, env);
      in.bonuses = params_.bonuses;
      in.ball_speed = launch_.linear_velocity(env).norm();
      in.ball_spin = launch_.angular_velocity(env).norm();
      in.robot_static = is_robot_static_[env] != 0;
      const GrabRewardTerms terms = grab_reward(in);
      reward_dict_.note(env, [&](auto& row) { list_terms(row, in, terms); });
      *out.row(env) = static_cast<float>(terms.reward);
    }
  }

  // --- observation ---

  void observe(Range envs, FloatRows out) override { write_state(*this, envs, out); }

  template <class Visitor>
  void state_row(Visitor& row, int env) const {
    row.field("ball_pose", 7, "m", "position, quaternion (w, x, y, z)",
              [&](RowWriter& out) { launch_.add_pose(env, out); });
    row.field("oracle_info", 3, "m/s", "initial velocity of the ball",
              [&] { return launch_.initial_velocity(env); });
    row.field("is_ball_grasped", 1, "", "", [&] { return is_ball_grasped_[env]; });
    row.field("ball_linear_vel", 3, "m/s", "", [&] { return launch_.linear_velocity(env); });
    row.field("ball_angular_vel", 3, "rad/s", "about the world's axes",
              [&] { return launch_.angular_velocity(env); });
    row.field("tcp_to_ball_pos", 3, "m", "",
              [&] { return Vector(launch_.ball(env) - launch_.tcp(env)); });
    row.field("gripper_width", 1, "m", "sum of both finger positions",
              [&] { return gripper_width(env); });
    row.field("relative_velocity", 3, "m/s", "of the ball, as seen from the TCP",
              [&] { return Vector(launch_.linear_velocity(env) - tcp_velocity(env)); });
  }

  // --- expert ---

  const Expert& expert() const override { return expert_; }
  const Annotator* annotator() const override { return &annotator_; }

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

  Params params_;
  BallLaunch launch_;
  RewardDict reward_dict_;
  Column<std::uint8_t> is_ball_grasped_;
  Column<std::uint8_t> is_robot_static_;
  GrabExpert expert_;
  InterceptAnnotator annotator_;
};

}  // namespace

GrabRewardTerms grab_reward(const GrabRewardInputs& in) {
  GrabRewardTerms terms;
  terms.offset = (in.ball - in.tcp).cwiseAbs();
  const Vector& offset = terms.offset;
  const double width = in.gripper_width;
  const double diameter = 2 * in.ball_radius;
  terms.distance = offset.norm();
  terms.in_gripper = offset.x() <= 0.04 && offset.y() <= 0.04 && offset.z() <= 0.03 &&
                     terms.distance <= 0.04 && width >= diameter;
  terms.very_close = terms.distance <= 0.025;
  terms.ball_stillness = 1 - real::tanh(10 * in.ball_speed + in.ball_spin);

  double reward = 10 * (1 - real::tanh(3 * terms.distance));
  if (terms.in_gripper) {
    reward += 10 + 90 * real::exp(-5 * std::max(std::abs(width - diameter) - 0.02, 0.0));
    if (width <= diameter + 0.02) reward += in.bonuses.attempt;
  }
  if (terms.very_close) reward += 30 * (1 - terms.distance / 0.06);
  if (in.grasped) reward += in.bonuses.grasp;
  terms.reward = in.success ? kSuccessReward : reward - in.penalty;
  return terms;
}

constexpr auto kRows = rows_of(kVariants);

const Family kInterceptGrab = {.name = "InterceptGrab",
                               .memory_type = "Spatial",
                               .instruction = "Intercept the rolling ball and grasp it to stop it.",
                               .tasks = kRows,
                               .make = make_variant<InterceptGrab, kVariants>,
                               .expectations = {.min_reward = 0,
                                                .max_reward = 1.4334,
                                                .moves_untouched = true,
                                                .settles = false},
                               .memory = {.no_counterfactuals = "nothing is hidden"}};

}  // namespace engram::tasks
