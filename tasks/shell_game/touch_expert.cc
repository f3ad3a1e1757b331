#include "tasks/shell_game/touch_expert.h"

#include <algorithm>
#include <cmath>

#include "tasks/common/tcp_servo.h"
#include "tasks/common/tour.h"

namespace engram::tasks {
namespace {

// Approach of the mug.
constexpr double kTravelGap = 0.063;    // m more during the approach
constexpr double kDescent = 0.04;       // m at most at a time: fast tools overshoot
constexpr double kCloseEnough = 0.003;  // m
// The farthest slots of all are out of a vertical tool's reach.
constexpr Tilt kTilt{.reach = 0.78, .per_metre = 5.0, .most = 0.4};

// Without memory: from mug to mug.
constexpr double kBegun = 0.012;       // m above a touch: a tool below that has begun
constexpr double kTouchFunnel = 0.02;  // m: the approach to the first one
constexpr double kTouchSlope = 0.5;
constexpr double kLower = 0.002;      // m below a touch of the oracle
constexpr double kRestRadius = 0.03;  // m at most, around a touch, where the tool comes to rest
constexpr double kMargin = 0.005;     // m
constexpr double kLeaving = 0.2;      // rad/s, of the base: the tool goes on from the first one

Eigen::Quaterniond tool_over(const Eigen::Vector3d& goal) {
  const bool far = (goal - Eigen::Vector3d(kRobotBaseX, 0, goal.z())).norm() > kTilt.reach;
  return far ? tilt_outwards(kToolDown, goal, kTilt) : kToolDown;
}

}  // namespace

void TouchExpert::act(Range envs, Script script, FloatRows actions) const {
  // Demonstrations of the Long ids keep the fingers open all the time.
  const bool open = !game_.info().frozen_cue && !game_.params().task.is_rl();
  const double gripper = open ? kGripperOpen : kGripperClosed;
  for (int env = envs.begin; env < envs.end; ++env) {
    float* action = actions.row(env);
    if (!game_.is_manipulation(env)) {
      hold_tcp(kGripperOpen, action);
    } else if (script == Script::kSweep && !game_.is_answer_visible()) {
      sweep(env, gripper, action);
    } else {
      touch(env, chosen_slot(env, script), gripper, action);
    }
  }
}

void TouchExpert::touch(int env, int slot, double gripper, float* action) const {
  const Eigen::Vector3d goal =
      game_.mugs().standing_pos(env, slot) + Eigen::Vector3d(0, 0, touch_gap_);
  const Eigen::Vector3d tcp = game_.tcp_pos(env);
  if ((tcp - goal).norm() < kCloseEnough) {
    hold_tcp(gripper, action);
    return;
  }
  Eigen::Vector3d waypoint = approach_from_above(game_.state(), env, goal, kTravelGap);
  waypoint.z() = std::max(waypoint.z(), tcp.z() - kDescent);
  servo_tcp(game_.state(), env, waypoint, tool_over(goal), gripper, action);
}

// Without memory: rests over one mug after the other. The last step of a shuffle looks like those
// in between, so that where the robot is not frozen it waits for as long as a shuffle may take.
void TouchExpert::sweep(int env, double gripper, float* action) const {
  const State& state = game_.state();
  if (!game_.info().frozen_cue && state.elapsed[env] < latest_start_) {
    hold_tcp(gripper, action);
    return;
  }
  const double gap = touch_gap_ - kLower;
  const auto over = [&](int slot) -> Eigen::Vector3d {
    return game_.mugs().standing_pos(env, slot) + Eigen::Vector3d(0, 0, gap);
  };
  const double start_height = over(0).z() + kBegun;
  const double reach =
      std::min(kRestRadius, std::sqrt(goal_thresh_ * goal_thresh_ - gap * gap) - kMargin);
  Tour::Target next{approach_by_funnel(state, env, over(0), kTouchFunnel, kTouchSlope)};
  if (game_.tcp_pos(env).z() < start_height) {
    Tour tour;
    const bool leaves_first = state.qvel.row(env)[0] > kLeaving;
    for (int slot = leaves_first ? 1 : 0; slot < kCups; ++slot) tour.add(over(slot));
    next = tour.next(state, env, {.start_height = start_height, .reach = reach});
  }
  if (next.rest) {
    hold_tcp(gripper, action);
  } else {
    servo_tcp(state, env, next.goal, tool_over(next.goal), gripper, action);
  }
}

}  // namespace engram::tasks
