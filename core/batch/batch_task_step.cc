// Steps and resets of a batch whose task has rules that are called for many environments at once.
// Physics and images are shared by the worker threads, as in other batches; the rules run
// between them.
#include <algorithm>

#include "core/base/ieee_scope.h"
#include "core/batch/batch.h"

namespace engram {

void Batch::step_batch_task(const float* actions, std::span<const std::uint8_t> commanded) {
  const IeeeScope scope;
  interrupted_ = true;  // unless the end is reached
  list_steps();
  for (const int env : work_.stepping) {
    const bool has_command = commanded.empty() || commanded[static_cast<std::size_t>(env)] != 0;
    take_action(env, has_command ? actions : nullptr);
  }
  if (rules_->moves_before_physics() && !work_.stepping.empty()) {
    rules_->before_physics(work_.stepping);
  }
  move_stepping(actions, commanded);
  if (!work_.stepping.empty()) {
    judge(work_.stepping);
    if (has_dense_reward()) rules_->dense_reward(work_.stepping, {reward_.data(), 1});
  }
  end_steps();
  begin_episodes();
  interrupted_ = false;
}

// Sorts the environments into those that step, those in which an episode begins, and those that are
// left alone.
void Batch::list_steps() {
  work_.stepping.clear();
  for (int env = 0; env < num_envs(); ++env) {
    const auto place = static_cast<std::size_t>(env);
    final_mask_[place] = 0;
    work_.begins[place] = 0;
    if (!waits(env)) {
      work_.stepping.push_back(env);
    } else if (options_.auto_reset != AutoReset::kOff) {
      work_.begins[place] = 1;
      work_.episodes[place] = {state_.seed[env], state_.episode[env] + 1};
    } else {
      reward_[env] = 0;
      if (images_) images_->repeat(env);
    }
  }
}

void Batch::move_stepping(const float* actions, std::span<const std::uint8_t> commanded) {
  const auto has_command = [&](int env) {
    return actions != nullptr &&
           (commanded.empty() || commanded[static_cast<std::size_t>(env)] != 0);
  };
  pool_.run(num_envs(), options_.chunk, [&](int worker, int begin, int end) {
    if (clock_ != nullptr) clock(worker)->start();
    for (int env = begin; env < end;) {
      if (waits(env)) {
        ++env;
        continue;
      }
      // Neighbours that are alike move together.
      const int first = env;
      const int most = std::min(end, first + Simulator::kMaxTogether);
      while (env < most && !waits(env) && has_command(env) == has_command(first)) ++env;
      run_physics(worker, {first, env}, has_command(first) ? actions : nullptr);
    }
  });
}

// Phases, success, infos and the task's part of the observation.
void Batch::judge(std::span<const int> envs) {
  rules_->advance(envs);
  rules_->evaluate(envs);
  if (bindings_.strict) {
    for (const int env : envs) fail_wrong_answers(env);
  }
  if (observes_state(options_.obs_mode)) rules_->observe(envs, task_rows());
}

void Batch::end_steps() {
  pool_.run(num_envs(), options_.chunk, [&](int worker, int begin, int end) {
    if (clock_ != nullptr) clock(worker)->start();
    for (int env = begin; env < end; ++env) {
      if (waits(env)) continue;
      observe_robot(env);
      scale_reward(env);
      mark(clock(worker), StepPart::kObservation);
      render_observation(worker, env);
      if (!end_step(env)) continue;
      work_.begins[static_cast<std::size_t>(env)] = 1;
      work_.episodes[static_cast<std::size_t>(env)] = {state_.seed[env], state_.episode[env] + 1};
    }
  });
}

void Batch::reset_batch_task(const CheckedReset& reset) {
  const ResetRequest& request = reset.request;
  for (int env = 0; env < num_envs(); ++env) {
    const auto place = static_cast<std::size_t>(env);
    work_.begins[place] = reset.selects(env) ? 1 : 0;
    if (!reset.selects(env)) continue;
    work_.episodes[place] = next_episode(env, request);
    if (reset.pins != nullptr) pins_.set(env, *reset.pins);
    if (request.constants != nullptr) pins_.narrow(env, reset.ranges);
    final_mask_[place] = 0;
  }
  interrupted_ = true;  // unless the end is reached
  begin_episodes();
  interrupted_ = false;
  started_ = true;
}

// Begins the episodes that are due. Where one has ended in this step, its reward and its endings
// stay.
void Batch::begin_episodes() {
  work_.beginning.clear();
  for (int env = 0; env < num_envs(); ++env) {
    if (work_.begins[static_cast<std::size_t>(env)] != 0) work_.beginning.push_back(env);
  }
  const std::span<const int> envs = work_.beginning;
  const int count = static_cast<int>(envs.size());
  if (count > 0) {
    pool_.run(count, options_.chunk, [&](int worker, int begin, int end) {
      if (clock_ != nullptr) clock(worker)->start();
      for (const int env :
           envs.subspan(static_cast<std::size_t>(begin), static_cast<std::size_t>(end - begin))) {
        const auto place = static_cast<std::size_t>(env);
        const float reward = reward_[env];
        const std::uint8_t flags[3] = {terminated_[env], truncated_[env], unstable_[env]};
        begin_episode(worker, env, work_.episodes[place].first, work_.episodes[place].second);
        if (final_mask_[place] == 0) continue;
        reward_[env] = reward;
        terminated_[env] = flags[0];
        truncated_[env] = flags[1];
        unstable_[env] = flags[2];
      }
      mark(clock(worker), StepPart::kReset);
    });
    rules_->reset(envs);
    judge(envs);
    pool_.run(count, options_.chunk, [&](int worker, int begin, int end) {
      if (clock_ != nullptr) clock(worker)->start();
      for (const int env :
           envs.subspan(static_cast<std::size_t>(begin), static_cast<std::size_t>(end - begin))) {
        observe_robot(env);
        mark(clock(worker), StepPart::kObservation);
        render_observation(worker, env);
      }
    });
  }
  if (copies_ == nullptr) return;
  pool_.run(num_envs(), options_.chunk, [&](int /*worker*/, int begin, int end) {
    copy_outputs({begin, end});
  });
}

}  // namespace engram
