#include "tasks/shell_game/push.h"

#include <algorithm>
#include <cmath>

#include "tasks/parts/tool_servo.h"
#include "tasks/shell_game/game.h"

namespace engram::tasks {
namespace {

constexpr double GOAL_THRESH = 0.06;                   // m
constexpr double kPlacedDistance = 1.6 * GOAL_THRESH;  // m
constexpr double kStaticSpeed = 0.3;                   // rad/s
constexpr double kReachedDistance = 0.08;              // m
constexpr double kSuccessReward = 4;
const Eigen::Vector3d kGoalFromBall(0.1, 0, 0.03);  // m

// The oracle's way (shell 8.3): down behind the mug, forward with the fingers closed until it has
// moved far enough. The pace keeps the mug from sliding on.
constexpr double kBehind = 0.13;          // m, from the mug's origin
constexpr double kPushHeight = 0.07;      // m, of the TCP
constexpr double kPushHeightBand = 0.02;  // m
constexpr double kLaneWidth = 0.02;       // m
constexpr double kTravel = 0.05;          // m, of the mug
constexpr double kPushLead = 0.03;        // m, that the tool's target is ahead of it
constexpr double kFunnel = 0.03;  // m: the tool stays above a cone that opens at this radius
constexpr double kFunnelSlope = 1.2;

class ShellGamePush final : public ShellGame {
 public:
  explicit ShellGamePush(const RegistryEntry& entry)
      : ShellGame(entry, {.GOAL_THRESH = GOAL_THRESH,
                          .target = "cup_with_ball_number",
                          .target_description = "slot of the mug that hides the ball",
                          .success_reward = kSuccessReward}),
        ball_(add_red_ball()),
        goal_(add_goal_site(GOAL_THRESH)) {
    info_.termination = Termination::kSuccess;
    info_.phases = cue_manipulation_phases();
    info_.state_fields = {{"goal_pos", 3, DType::kFloat32, "m", "centre of the goal region"},
                          {"obj_pose", 7, DType::kFloat32, "m", "of the mug over the ball"},
                          {"ball_pose", 7, DType::kFloat32, "m", "of the red ball"},
                          {"oracle_info", 1, DType::kFloat32, "", "slot of the ball"}};
    info_.reward_terms = {
        "reaching_reward", "static_reward",    "is_robot_static",         "place_reward",
        "tcp_to_obj_dist", "obj_to_goal_dist", "info[\"is_obj_placed\"]", "reached_status"};
  }

  void advance(Range envs) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      if (engine_.state->elapsed[env] == 0) place_sphere(env, goal_, goal_pos(env));
      play_free_mugs(env, ball_);
    }
  }

  void evaluate(Range envs) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      engine_.oracle_info[env] = target_[env];
      const Eigen::Vector3d offset = goal_pos(env) - mug_pos(env, target_[env]);
      conclude(env, {.obj_to_goal = offset,
                     .placed = offset.norm() <= kPlacedDistance,
                     .still = robot_is_static(*engine_.state, env, kStaticSpeed)});
    }
  }

  void observe(Range envs, FloatRows out) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      float* next = write_point(goal_pos(env), out.row(env));
      next = write_pose(env, target_[env], next);
      next = write_pose(env, ball_, next);
      *next = static_cast<float>(target_[env]);
    }
  }

  void dense_reward(Range envs, FloatRows out) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      ShellPushInputs in;
      in.distance = (mug_pos(env, target_[env]) - tcp_pos(env)).norm();
      in.to_goal = obj_to_goal_distance(env);
      in.arm_speed = arm_speed(env);
      in.robot_static = is_robot_static_[env] != 0;
      in.placed = is_obj_placed_[env] != 0;
      in.manipulation = is_manipulation(env);
      in.success = engine_.success[env] != 0;
      const ShellPushTerms terms = shell_push_reward(in);
      reward_dict_.note<8>(
          env, {terms.reaching, terms.stillness, in.robot_static ? 1.0 : 0.0, terms.place,
                in.distance, in.to_goal, in.placed ? 1.0 : 0.0, terms.reached ? 1.0 : 0.0});
      *out.row(env) = static_cast<float>(terms.reward);
    }
  }

  void act(Range envs, bool blind, FloatRows actions) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      float* action = actions.row(env);
      const int slot = chosen_slot(env, blind);
      const Eigen::Vector3d start =
          slot_pos(env, slot, kPushHeight) - Eigen::Vector3d(kBehind, 0, 0);
      const double moved = mug_pos(env, slot).x() - base(env).x();
      if (!is_manipulation(env) || moved >= kTravel) {
        hold_tool(kGripperClosed, action);
        continue;
      }
      const Eigen::Vector3d tcp = tcp_pos(env);
      const bool pushing =
          std::abs(tcp.y() - start.y()) < kLaneWidth && tcp.z() < kPushHeight + kPushHeightBand;
      const Eigen::Vector3d goal =
          pushing ? Eigen::Vector3d(tcp.x() + kPushLead, start.y(), start.z())
                  : approach_by_funnel(*engine_.state, env, start, kFunnel, kFunnelSlope);
      servo_tool(*engine_.state, env, goal, kToolDown, kGripperClosed, action);
    }
  }

 private:
  Eigen::Vector3d goal_pos(int env) const {
    return slot_pos(env, target_[env], BALL_RADIUS) + kGoalFromBall;
  }

  int ball_;
  int goal_;
};

}  // namespace

ShellPushTerms shell_push_reward(const ShellPushInputs& in) {
  ShellPushTerms terms;
  terms.reaching = 1 - std::tanh(10 * in.distance);
  terms.place = 1 - std::tanh(5 * in.to_goal);
  terms.stillness = 1 - std::tanh(5 * in.arm_speed);
  terms.reached = in.distance <= kReachedDistance;
  if (!in.manipulation) return terms;
  if (in.success) {
    terms.reward = kSuccessReward;
    return terms;
  }
  terms.reward = terms.reaching;
  if (terms.reached) terms.reward += 2 * terms.place;
  if (in.placed) terms.reward += 0.2 * (terms.stillness + (in.robot_static ? 1 : 0));
  return terms;
}

std::unique_ptr<Task> make_shell_game_push(const RegistryEntry& entry) {
  return std::make_unique<ShellGamePush>(entry);
}

}  // namespace engram::tasks
