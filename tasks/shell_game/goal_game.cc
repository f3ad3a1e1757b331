#include "tasks/shell_game/goal_game.h"

namespace engram::tasks {

GoalGame::GoalGame(const RegistryEntry& entry, const ShellGameParams& params, const Setup& setup,
                   const Form& form)
    : ShellGame(entry, params, setup),
      form_(form),
      ball_(add_red_ball()),
      goal_(add_goal_site(params.GOAL_THRESH)),
      annotator_({.game = *this, .skill = form.skill, .ball = ball_}) {
  info_.phases = cue_manipulation_phases();
  declare_state(*this);
}

void GoalGame::bind(const Bindings& bindings) {
  ShellGame::bind(bindings);
  if (lifts()) is_grasped_ = bindings.outputs->add_privileged<std::uint8_t>("is_grasped");
}

void GoalGame::set_item(GoalItem item, double answer_distance) {
  item_ = item;
  answer_distance_ = answer_distance;
}

void GoalGame::advance(Range envs) {
  for (int env = envs.begin; env < envs.end; ++env) {
    if (engine_.state->elapsed[env] == 0) place_sphere(env, goal_, goal_pos(env));
    update_free_mugs(env, ball_, /*lifted_along=*/lifts() && item_ == GoalItem::kBall);
  }
}

void GoalGame::evaluate(Range envs) {
  const bool mug = item_ == GoalItem::kMug;
  for (int env = envs.begin; env < envs.end; ++env) {
    const State& state = *engine_.state;
    engine_.oracle_info[env] = target_[env];
    if (lifts()) is_grasped_[env] = is_grasping(state, env, target_[env]) ? 1 : 0;
    const Eigen::Vector3d offset = goal_pos(env) - (mug ? mug_pos(env) : prop_pos(env, ball_));
    const bool near = offset.norm() <= params().placed_distance(item_);
    set_outcome(env, {.obj_to_goal = offset,
                      .placed = near && (mug || is_ball_moved(env)),
                      .still = robot_is_static(state, env, form_.static_speed)});
    note_answer(env, moved_mug(env, answer_distance_));
  }
}

// A ball that lies in the region from the start has to be pushed or lifted all the same.
bool GoalGame::is_ball_moved(int env) const {
  const Eigen::Vector3d way = prop_pos(env, ball_) - ball_slot(env);
  return (lifts() ? way.z() : way.x()) >= kMinBallTravel;
}

}  // namespace engram::tasks
