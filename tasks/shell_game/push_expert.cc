#include "tasks/shell_game/push_expert.h"

#include <algorithm>
#include <cmath>

#include "tasks/common/tcp_servo.h"

namespace engram::tasks {
namespace {

// Push of the benchmark's mugs. The pace keeps the mug from sliding on.
constexpr double kBehind = 0.13;          // m, from the mug's origin
constexpr double kPushHeight = 0.07;      // m, of the TCP
constexpr double kPushHeightBand = 0.02;  // m
constexpr double kLaneWidth = 0.02;       // m
constexpr double kTravel = 0.05;          // m, of the mug, or more if the goal asks for it
constexpr double kPushIntoGoal = 0.02;    // m
constexpr double kPushLead = 0.03;        // m, that the tool's target is ahead of it
constexpr double kPushFunnel = 0.03;  // m: the tool stays above a cone that opens at this radius
constexpr double kPushSlope = 1.2;

// Without memory: pushes all of them with the hand.
constexpr double kSweepTravel = 0.012;
constexpr double kSweepIntoGoal = 0.004;
constexpr double kSweepLead = 0.06;
constexpr double kSweepBehind = 0.12;
constexpr double kSweepHeight = 0.03;
constexpr double kSweepClear = 0.02;

}  // namespace

PushExpert::PushExpert(const ShellGame& game, const ShellGameParams& params)
    : ShellGameExpert(game),
      behind_(kBehind * params.mug_ratio()),
      push_height_(kPushHeight * params.mug_ratio()),
      half_pitch_(params.MIN_DIST / 2) {}

void PushExpert::set_goal(GoalItem item, double travel, double reach, double leeway) {
  const bool mug = item == GoalItem::kMug;
  travel_ = std::max(kTravel, travel + std::min(kPushIntoGoal, 0.2 * reach));
  lead_ = std::min(kPushLead, mug ? reach : leeway);
  first_lead_ = mug ? lead_ : kPushLead;
  sweep_travel_ = std::max(mug ? kSweepTravel : 0.0, travel + kSweepIntoGoal);
  sweep_lead_ = mug ? lead_ : kSweepLead;
}

void PushExpert::act(Range envs, Script script, FloatRows actions) const {
  for (int env = envs.begin; env < envs.end; ++env) {
    float* action = actions.row(env);
    if (script == Script::kSweep && game_.is_manipulation(env)) {
      sweep(env, action);
    } else {
      push(env, chosen_slot(env, script), action);
    }
  }
}

void PushExpert::push(int env, int slot, float* action) const {
  const Mugs& mugs = game_.mugs();
  const Eigen::Vector3d start =
      mugs.slot_pos(env, slot, push_height_) - Eigen::Vector3d(behind_, 0, 0);
  const double moved = mugs.pos(env, slot).x() - mugs.base(env).x();
  if (!game_.is_manipulation(env) || moved >= travel_) {
    hold_tcp(game_.is_manipulation(env) ? kGripperClosed : kGripperOpen, action);
    return;
  }
  const Eigen::Vector3d tcp = game_.tcp_pos(env);
  const double lead = std::max(lead_, std::min(first_lead_, travel_ - moved));
  const bool pushing =
      std::abs(tcp.y() - start.y()) < kLaneWidth && tcp.z() < push_height_ + kPushHeightBand;
  const Eigen::Vector3d goal =
      pushing ? Eigen::Vector3d(tcp.x() + lead, start.y(), start.z())
              : approach_by_funnel(game_.state(), env, start, kPushFunnel, kPushSlope);
  servo_tcp(game_.state(), env, goal, kToolDown, kGripperClosed, action);
}

// Pushes the mugs that visibly still stand in the row: the hand is as wide as two slots.
void PushExpert::sweep(int env, float* action) const {
  const Mugs& mugs = game_.mugs();
  const Eigen::Vector3d center = mugs.base(env);
  const auto pushed = [&](int slot) {
    return mugs.pos(env, slot).x() - center.x() > sweep_travel_;
  };
  const bool pair = pushed(0) && pushed(1);
  if (pair && pushed(2)) {
    hold_tcp(kGripperClosed, action);
    return;
  }
  const Eigen::Vector3d start(center.x() - kSweepBehind,
                              center.y() + (pair ? half_pitch_ : -half_pitch_), kSweepHeight);
  const Eigen::Vector3d tcp = game_.tcp_pos(env);
  const bool low = tcp.z() < kSweepHeight + kPushHeightBand;
  Eigen::Vector3d goal = start;
  if (!low) {
    goal = approach_by_funnel(game_.state(), env, start, kPushFunnel, kPushSlope);
  } else if (std::abs(tcp.y() - start.y()) < kLaneWidth) {
    goal.x() = tcp.x() + sweep_lead_;
  } else if (tcp.x() > start.x() + kSweepClear) {
    goal.y() = tcp.y();
  }
  servo_tcp(game_.state(), env, goal, kToolDown, kGripperClosed, action);
}

}  // namespace engram::tasks
