#include "tasks/colors/touch_task.h"

namespace engram::tasks {

ColorTouch::ColorTouch(const RegistryEntry& entry, const ColorRecallParams& params)
    : ColorTouchBase(entry, params),
      expert_({.engine = engine_,
               .info = info_,
               .params = params_,
               .rule = rule_,
               .cubes = cubes_,
               .clock = clock_,
               .touch = touch_,
               .sequence = sequence_}),
      annotator_(expert_) {
  // Seq is judged as Bunch is: in any order, the lowest colour being the next target.
  if (rule_ == ColorRule::kSeq) rule_ = ColorRule::kBunch;
  info_.reward_terms = reward_terms_of(ColorTouchReward{.rule = params.rule});
  declare_state(*this);
}

void ColorTouch::bind(const Bindings& bindings) {
  bind_touches(bindings);
  bind_sequence(bindings);
  bind_info(*bindings.outputs);
}

void ColorTouch::advance(Range envs) {
  for (int env = envs.begin; env < envs.end; ++env) show_phase(env, 1);
}

void ColorTouch::evaluate(Range envs) {
  for (int env = envs.begin; env < envs.end; ++env) {
    const bool complete = evaluate_touches(env).complete();
    const bool still = note_static(env);
    engine_.success[env] = complete && still && is_acting(env) ? 1 : 0;
    const int next = next_target(env);
    set_goal(env, next < 0 ? Eigen::Vector3d(0, 0, 0)
                           : Eigen::Vector3d(touch_.touch_point(env, next) - tcp_pos(env)));
    reward_dict_.publish(env);
  }
}

void ColorTouch::dense_reward(Range envs, FloatRows out) {
  reward_dict_.write(envs, out, [&](int env) { return touch_reward(env); });
}

// The colour to be touched next, -1: none. In Chain the last one of the cue stays the goal.
int ColorTouch::next_target(int env) const {
  if (!is_acting(env)) return -1;
  const int next = count_touches(env).next;
  return next < 0 && rule_ == ColorRule::kChain ? sequence(env).back() : next;
}

}  // namespace engram::tasks
