#include "tasks/shell_game/pick.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tasks/parts/tool_servo.h"
#include "tasks/shell_game/game.h"

namespace engram::tasks {
namespace {

constexpr double GOAL_THRESH = 0.05;                   // m
constexpr double kPlacedDistance = 1.6 * GOAL_THRESH;  // m
constexpr double HANDLE_OFFSET_X = 0.045;              // m
constexpr double HANDLE_OFFSET_Y = 0.043;              // m
constexpr double kReachedDistance = 0.04;              // m
constexpr double kGripperOpening = 0.08;               // m
constexpr double kSuccessReward = 75;
const Eigen::Vector3d kGoalFromBall(0, 0, 0.125);                            // m
const Eigen::Vector3d kHandleFromMug(-HANDLE_OFFSET_X, HANDLE_OFFSET_Y, 0);  // m, world axes

// --- the oracle (shell 8.4): straddle the handle's bar from above, close, lift ---

// The bar's middle, seen from the mug's origin, m.
const Eigen::Vector3d kGripFromMug(-0.0635, 0.0480, 0);
// The tool turned so that the fingers close across the bar: -43.6 degrees about z.
const Eigen::Quaterniond kGripTool =
    Eigen::AngleAxisd(-43.6 * std::numbers::pi / 180, Eigen::Vector3d::UnitZ()) * kToolDown;
constexpr double kGripHeight = 0.072;  // m, of the TCP: the palm clears the mug's foot by 3 mm
constexpr double kHoverHeight = 0.12;  // m: fingertips above the mugs
constexpr double kFunnel = 0.01;       // m: the way down begins this near
constexpr double kFunnelSlope = 2;
constexpr double kGripTurn = 0.25;       // rad: turned enough to come down
constexpr double kGripRadius = 0.012;    // m: near enough to the grip to close
constexpr double kHoldingWidth = 0.022;  // m: fingers this close together hold the bar
constexpr double kLift = 0.02;           // m, of the mug

class ShellGamePick final : public ShellGame {
 public:
  explicit ShellGamePick(const RegistryEntry& entry)
      : ShellGame(entry, {.GOAL_THRESH = GOAL_THRESH,
                          .target = "cup_with_ball_number",
                          .target_description = "slot of the mug that hides the ball",
                          .frozen = false,
                          .success_reward = kSuccessReward,
                          .stance = &kHandleTowardsRobot}),
        ball_(add_red_ball()),
        goal_(add_goal_site(GOAL_THRESH)) {
    info_.termination = Termination::kSuccess;
    info_.phases = cue_manipulation_phases();
    info_.constants.emplace_back("HANDLE_OFFSET_X", HANDLE_OFFSET_X);
    info_.constants.emplace_back("HANDLE_OFFSET_Y", HANDLE_OFFSET_Y);
    info_.state_fields = {{"goal_pos", 3, DType::kFloat32, "m", "centre of the goal region"},
                          {"obj_pose", 7, DType::kFloat32, "m", "of the mug over the ball"},
                          {"handle_pos", 3, DType::kFloat32, "m", "nominal grip of that mug"},
                          {"ball_pose", 7, DType::kFloat32, "m", "of the red ball"},
                          {"oracle_info", 1, DType::kFloat32, "", "slot of the ball"},
                          {"is_grasped", 1, DType::kFloat32, "", "of that mug"}};
    info_.reward_terms = {"reaching_reward",
                          "open_gripper_reward",
                          "grasp_reward",
                          "reached_status",
                          "info[\"is_grasped\"]",
                          "place_reward",
                          "static_reward",
                          "tcp_to_handle_dist",
                          "tcp_to_obj_dist",
                          "obj_to_goal_dist",
                          "info[\"is_obj_placed\"]",
                          "gripper_width",
                          "dx_handle",
                          "dy_handle",
                          "dz_handle"};
  }

  void bind(const Bindings& bindings) override {
    ShellGame::bind(bindings);
    is_grasped_ = bindings.outputs->add<std::uint8_t>("is_grasped");
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
      is_grasped_[env] = is_grasping(*engine_.state, env, target_[env]) ? 1 : 0;
      const Eigen::Vector3d offset = goal_pos(env) - mug_pos(env, target_[env]);
      conclude(env, {.obj_to_goal = offset,
                     .placed = offset.norm() <= kPlacedDistance,
                     .still = robot_is_static(*engine_.state, env)});
    }
  }

  void observe(Range envs, FloatRows out) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      float* next = write_point(goal_pos(env), out.row(env));
      next = write_pose(env, target_[env], next);
      next = write_point(handle_pos(env), next);
      next = write_pose(env, ball_, next);
      next[0] = static_cast<float>(target_[env]);
      next[1] = is_grasped_[env];
    }
  }

  void dense_reward(Range envs, FloatRows out) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      const Eigen::Vector3d to_handle = handle_pos(env) - tcp_pos(env);
      ShellPickInputs in;
      in.to_handle = to_handle.norm();
      in.to_goal = obj_to_goal_distance(env);
      in.arm_speed = arm_speed(env);
      in.gripper_width = gripper_width(env);
      in.grasped = is_grasped_[env] != 0;
      in.robot_static = is_robot_static_[env] != 0;
      in.placed = is_obj_placed_[env] != 0;
      in.manipulation = is_manipulation(env);
      in.success = engine_.success[env] != 0;
      const ShellPickTerms terms = shell_pick_reward(in);
      reward_dict_.note<15>(
          env,
          {terms.reaching, terms.open, terms.grasp, terms.reached ? 1.0 : 0.0,
           in.grasped ? 1.0 : 0.0, terms.place, terms.stillness, in.to_handle,
           (mug_pos(env, target_[env]) - tcp_pos(env)).norm(), in.to_goal, in.placed ? 1.0 : 0.0,
           in.gripper_width, to_handle.x(), to_handle.y(), to_handle.z()});
      *out.row(env) = static_cast<float>(terms.reward);
    }
  }

  // There is no frozen cue here, and turning the hand takes twenty steps: it hovers over the slot
  // while the cue still shows.
  void act(Range envs, bool blind, FloatRows actions) override {
    for (int env = envs.begin; env < envs.end; ++env) {
      const int slot = chosen_slot(env, blind);
      const Eigen::Vector3d grip =
          slot_pos(env, slot, kGripHeight) + Eigen::Vector3d(kGripFromMug.x(), kGripFromMug.y(), 0);
      const double lifted = mug_pos(env, slot).z() - mug_slot_pos(env, slot).z();
      const bool closing = (tcp_pos(env) - grip).norm() < kGripRadius;
      const bool holding = closing && gripper_width(env) < kHoldingWidth;
      Eigen::Vector3d goal = approach_by_funnel(*engine_.state, env, grip, kFunnel, kFunnelSlope);
      double gripper = kGripperOpen;
      if (!is_manipulation(env) || turn_left(env) > kGripTurn) {
        goal.z() = std::max(goal.z(), kHoverHeight);
      } else if (holding || lifted > kTakenUp) {
        gripper = kSqueeze;
        goal = tcp_pos(env) + Eigen::Vector3d(0, 0, lifted > kLift ? 0 : kLiftLead);
      } else if (closing) {
        gripper = kSqueeze;
      }
      servo_tool(*engine_.state, env, goal, kGripTool, gripper, actions.row(env));
    }
  }

 private:
  static constexpr double kSqueeze = -1;     // drives the fingers into what they hold
  static constexpr double kLiftLead = 0.03;  // m, that the tool's target is above it
  static constexpr double kTakenUp = 0.002;  // m: a mug this high hangs in the fingers

  Eigen::Vector3d goal_pos(int env) const {
    return slot_pos(env, target_[env], BALL_RADIUS) + kGoalFromBall;
  }
  Eigen::Vector3d handle_pos(int env) const { return mug_pos(env, target_[env]) + kHandleFromMug; }
  double gripper_width(int env) const {
    const double* qpos = engine_.state->qpos.row(env);
    return qpos[kArmJoints] + qpos[kArmJoints + 1];
  }
  // The angle by which the tool still has to turn.
  double turn_left(int env) const {
    const double* quat = engine_.state->tcp_quat.row(env);
    return kGripTool.angularDistance(Eigen::Quaterniond(quat[0], quat[1], quat[2], quat[3]));
  }

  int ball_;
  int goal_;
  Column<std::uint8_t> is_grasped_;
};

}  // namespace

ShellPickTerms shell_pick_reward(const ShellPickInputs& in) {
  ShellPickTerms terms;
  terms.reaching = 1 - std::tanh(10 * in.to_handle);
  terms.place = 1 - std::tanh(5 * in.to_goal);
  terms.stillness = 1 - std::tanh(5 * in.arm_speed);
  terms.reached = in.to_handle <= kReachedDistance;
  terms.open = terms.reached ? 0 : in.gripper_width / kGripperOpening;
  terms.grasp = terms.reached && in.grasped ? 1 : 0;
  if (!in.manipulation) return terms;
  if (in.success) {
    terms.reward = kSuccessReward;
    return terms;
  }
  terms.reward = 3 * terms.reaching + 1.5 * terms.open + (terms.reached ? 2 : 0) + 10 * terms.grasp;
  if (!in.grasped) return terms;
  terms.reward += 30 * terms.place;
  if (in.placed) terms.reward += 5 * (terms.stillness + (in.robot_static ? 1 : 0));
  return terms;
}

std::unique_ptr<Task> make_shell_game_pick(const RegistryEntry& entry) {
  return std::make_unique<ShellGamePick>(entry);
}

}  // namespace engram::tasks
