#include "tasks/shell_game/pick_expert.h"

#include <algorithm>
#include <numbers>

#include "core/math/real_functions.h"
#include "core/math/rotations.h"
#include "tasks/common/tcp_servo.h"

namespace engram::tasks {
namespace {

// Grasp of the benchmark's mugs. The bar's middle, seen from the mug's origin, m.
const Eigen::Vector3d kGripFromMug(-0.0635, 0.0480, 0);
// Fingers do not shrink with the mug: at a smaller one they grip farther out, clear of its wall.
const Eigen::Vector3d kFartherOut(-0.0130, 0.0124, 0);
constexpr double kGripYaw = -43.6 * std::numbers::pi / 180;  // the fingers close across the bar
constexpr double kGripHeight = 0.072;  // m, of the TCP: the palm clears the mug's foot by 3 mm
constexpr double kHoverHeight = 0.12;  // m: fingertips above the mugs
constexpr double kPickFunnel = 0.01;   // m: the descent begins this near
constexpr double kPickSlope = 2;
constexpr double kGripTurn = 0.25;       // rad: turned enough to come down
constexpr double kGripRadius = 0.012;    // m: near enough to the grip to close
constexpr double kHoldingWidth = 0.022;  // m: fingers this close together hold the bar
constexpr double kLift = 0.02;           // m, of the mug, or more if the goal asks for it
constexpr double kPickIntoGoal = 0.006;  // m
constexpr double kSqueeze = -1;          // drives the fingers into what they hold
constexpr double kLiftLead = 0.03;       // m, that the tool's target is above it
constexpr double kBallIntoGoal = 0.012;  // m
constexpr double kMaxLead = 0.045;       // m: faster, and the mug slips
constexpr double kTakenUp = 0.002;       // m: a mug this high hangs in the fingers

Eigen::Vector3d turned(const Eigen::Vector3d& v, double angle) {
  const double c = real::cos(angle);
  const double s = real::sin(angle);
  return {c * v.x() - s * v.y(), s * v.x() + c * v.y(), v.z()};
}

}  // namespace

PickExpert::PickExpert(const ShellGame& game, const ShellGameParams& params)
    : ShellGameExpert(game),
      waits_(params.task.is_rl()),
      grip_from_mug_(params.mug_ratio() * kGripFromMug +
                     std::max(0.0, 1 - params.mug_ratio()) * kFartherOut),
      grip_height_(std::max(params.resting_height(), kGripHeight + params.extra_height())),
      hover_height_(kHoverHeight + std::max(0.0, params.extra_height())),
      grip_radius_(kGripRadius * std::min(1.0, params.mug_ratio())),
      holding_width_(kHoldingWidth * params.mug_ratio()) {}

void PickExpert::lift_mug(double lift) {
  ball_ = false;
  lift_ = std::max(kLift, lift + kPickIntoGoal);
}

void PickExpert::lift_ball(double height, double reach) {
  ball_ = true;
  ball_height_ = std::max(kLift, height - std::max(0.0, reach - kBallIntoGoal));
}

void PickExpert::act(Range envs, Script script, FloatRows actions) const {
  for (int env = envs.begin; env < envs.end; ++env) {
    // There is time for one mug. The expert without memory goes for the middle one: a hand that
    // pointed at the ball while that shows would be a note of it.
    const int slot = script == Script::kSweep ? kMiddleSlot : chosen_slot(env, script);
    pick(env, slot, actions.row(env));
  }
}

// Turning the hand takes twenty steps. In the VLA task, whose cue is not frozen, it hovers over the
// slot while the cue still shows.
void PickExpert::pick(int env, int slot, float* action) const {
  if (waits_ && !game_.is_manipulation(env)) {
    hold_tcp(kGripperOpen, action);
    return;
  }
  const Mugs& mugs = game_.mugs();
  const State& state = game_.state();
  const Eigen::Vector3d tcp = game_.tcp_pos(env);
  const double* fingers = state.qpos.row(env) + kArmJoints;
  const Eigen::Vector3d grip =
      mugs.slot_pos(env, slot, grip_height_) + turned(grip_from_mug_, mugs.handle_turn(env));
  const double lifted = mugs.pos(env, slot).z() - mugs.standing_pos(env, slot).z();
  const bool closing = (tcp - grip).norm() < grip_radius_;
  const bool holding = closing && fingers[0] + fingers[1] < holding_width_;
  Eigen::Vector3d goal = approach_by_funnel(state, env, grip, kPickFunnel, kPickSlope);
  double gripper = kGripperOpen;
  if (!game_.is_manipulation(env) || remaining_turn(env) > kGripTurn) {
    goal.z() = std::max(goal.z(), hover_height_);
  } else if (holding || lifted > kTakenUp) {
    gripper = kSqueeze;
    goal = ball_ ? raised(env, slot) : tcp + Eigen::Vector3d(0, 0, lifted > lift_ ? 0 : kLiftLead);
  } else if (closing) {
    gripper = kSqueeze;
  }
  servo_tcp(state, env, goal, grip_tool(env), gripper, action);
}

// Where the tool brings what is inside the mug to its goal.
Eigen::Vector3d PickExpert::raised(int env, int slot) const {
  const Mugs& mugs = game_.mugs();
  const double radius = game_.params().BALL_RADIUS;
  Eigen::Vector3d way =
      mugs.slot_pos(env, slot, radius + ball_height_) - mugs.pos_inside(env, slot, radius);
  if (way.norm() > kMaxLead) way *= kMaxLead / way.norm();
  return game_.tcp_pos(env) + way;
}

Eigen::Quaterniond PickExpert::grip_tool(int env) const {
  return tool_down(kGripYaw + game_.mugs().handle_turn(env));
}

// Angle by which the tool still has to turn.
double PickExpert::remaining_turn(int env) const {
  const double* quat = game_.state().tcp_quat.row(env);
  return angle_between(grip_tool(env), Eigen::Quaterniond(quat[0], quat[1], quat[2], quat[3]));
}

}  // namespace engram::tasks
