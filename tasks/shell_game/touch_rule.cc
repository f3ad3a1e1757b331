#include "tasks/shell_game/touch_rule.h"

#include <algorithm>

#include "core/base/real_functions.h"
#include "tasks/parts/tool_servo.h"

namespace engram::tasks {
namespace {

constexpr double MUG_DISPLACEMENT_PENALTY_COEF = 0.1;
constexpr double MUG_DISPLACEMENT_SUCCESS_THRESH = 0.05;  // m
constexpr double kSuccessReward = 3;

// The oracle's way: over the mug, then down until it is touched.
constexpr double kTravelGap = 0.063;    // m more while on the way
constexpr double kDescent = 0.04;       // m at most at a time: fast tools overshoot
constexpr double kCloseEnough = 0.003;  // m
// The farthest slots of all are out of a vertical tool's reach.
constexpr Lean kLean{.reach = 0.78, .per_metre = 5.0, .most = 0.4};

bool is_fair(double displacement) { return displacement <= MUG_DISPLACEMENT_SUCCESS_THRESH; }

template <class Row>
void list_terms(Row& row, bool shoving, const TouchRule::RewardInputs& in,
                const TouchRule::RewardTerms& terms) {
  row.term("reaching_reward", "", terms.reaching);
  row.term("static_reward", "", terms.stillness);
  row.term("tcp_to_obj_dist", "m", in.distance);
  if (shoving) {
    row.term("mug_max_displacement", "m", in.displacement);
    row.term("mug_shift_penalty", "", terms.shift);
    row.term("is_mug_displacement_ok", "", is_fair(in.displacement));
  }
  row.term(shoving ? "info[\"is_obj_placed\"]" : "is_obj_placed", "", in.placed);
}

}  // namespace

void TouchRule::describe(TaskInfo& info) const {
  info.reward_terms = reward_terms_of([&](auto& row) { list_terms(row, shoving_, {}, {}); });
  if (!shoving_) return;
  info.constants.emplace_back("MUG_DISPLACEMENT_PENALTY_COEF", MUG_DISPLACEMENT_PENALTY_COEF);
  info.constants.emplace_back("MUG_DISPLACEMENT_SUCCESS_THRESH", MUG_DISPLACEMENT_SUCCESS_THRESH);
}

void TouchRule::bind(const Bindings& bindings) {
  displacement_ = bindings.memory->add<double>("mug_max_displacement", 1, "m");
  if (!shoving_) return;
  mug_max_displacement_ = bindings.outputs->add<float>(
      "mug_max_displacement", 1, "m", "farthest that a mug was shoved since it appeared");
  is_mug_displacement_ok_ = bindings.outputs->add<std::uint8_t>("is_mug_displacement_ok");
}

// --- success ---

ShellGame::Verdict TouchRule::judge(const ShellGame& game, int env, const Eigen::Vector3d& goal,
                                    double displacement) const {
  const Eigen::Vector3d offset = goal - game.tcp_pos(env);
  displacement_[env] = displacement;
  if (shoving_) {
    mug_max_displacement_[env] = static_cast<float>(displacement);
    is_mug_displacement_ok_[env] = is_fair(displacement) ? 1 : 0;
  }
  return {.obj_to_goal = offset,
          .placed = offset.norm() <= goal_thresh_,
          .still = robot_is_static(game.state(), env),
          .fair = is_fair(displacement)};
}

// --- reward ---

TouchRule::RewardTerms TouchRule::reward(const RewardInputs& in) {
  RewardTerms terms;
  terms.reaching = 1 - real::tanh(5 * in.distance);
  terms.stillness = 1 - real::tanh(5 * in.arm_speed);
  terms.shift = MUG_DISPLACEMENT_PENALTY_COEF * real::tanh(10 * in.displacement);
  if (in.success) {
    terms.reward = kSuccessReward;
  } else if (in.manipulation) {
    const double placed = in.placed ? terms.stillness + (in.robot_static ? 1 : 0) : 0;
    terms.reward = terms.reaching + placed - terms.shift;
  }
  return terms;
}

void TouchRule::dense_reward(const ShellGame& game, Range envs, FloatRows out) const {
  for (int env = envs.begin; env < envs.end; ++env) {
    RewardInputs in;
    in.distance = game.obj_to_goal(env).norm();
    in.displacement = displacement_[env];
    game.fill_in(env, in);
    const RewardTerms terms = reward(in);
    game.reward_dict().note(env, [&](auto& row) { list_terms(row, shoving_, in, terms); });
    *out.row(env) = static_cast<float>(terms.reward);
  }
}

// --- oracle ---

void TouchRule::act(const ShellGame& game, Range envs, Script script, FloatRows actions) const {
  // Demonstrations of the Long ids keep the fingers open all the time.
  const double hovering = game.info().frozen_cue ? kGripperClosed : kGripperOpen;
  for (int env = envs.begin; env < envs.end; ++env) {
    float* action = actions.row(env);
    const Eigen::Vector3d goal = game.mugs().standing_pos(env, game.chosen_slot(env, script)) +
                                 Eigen::Vector3d(0, 0, touch_gap_);
    const Eigen::Vector3d tcp = game.tcp_pos(env);
    if (!game.is_manipulation(env) || (tcp - goal).norm() < kCloseEnough) {
      hold_tool(game.is_manipulation(env) ? hovering : kGripperOpen, action);
    } else {
      Eigen::Vector3d way = approach_from_above(game.state(), env, goal, kTravelGap);
      way.z() = std::max(way.z(), tcp.z() - kDescent);
      const bool far = (goal - Eigen::Vector3d(kRobotBaseX, 0, goal.z())).norm() > kLean.reach;
      servo_tool(game.state(), env, way, far ? lean_outwards(kToolDown, goal, kLean) : kToolDown,
                 hovering, action);
    }
  }
}

}  // namespace engram::tasks
