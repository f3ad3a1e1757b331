// Steps of a batch.
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/error.h"
#include "core/batch/batch.h"

namespace engram {

void Batch::check_actions(std::span<const float> actions) const {
  require_started("step");
  const auto dim = static_cast<std::size_t>(action_dim());
  require_length("actions", actions.size(), static_cast<std::size_t>(num_envs()) * dim);
  require_finite(actions, dim);
  if (options_.after_end == AfterEnd::kRefuse) refuse_ended();
}

void Batch::require_finite(std::span<const float> actions, std::size_t dim) {
  const auto bad =
      std::ranges::find_if_not(actions, [](float value) { return std::isfinite(value); });
  if (bad == actions.end()) return;
  const auto index = static_cast<std::size_t>(bad - actions.begin());
  throw Error(Error::kInvalidArgument, "action of environment " + std::to_string(index / dim) +
                                           ", component " + std::to_string(index % dim) + ": " +
                                           std::to_string(*bad) + " given, a finite number needed");
}

// Throws Error if an episode has ended that nothing resets but the user.
void Batch::refuse_ended(int first) const {
  if (options_.auto_reset != AutoReset::kOff) return;
  for (int env = 0; env < num_envs(); ++env) {
    if (state_.finished[env] == 0) continue;
    throw Error(Error::kBadState,
                "the episode of environment " + std::to_string(first + env) +
                    " has ended; reset it, or make the batch with after_end hold or continue");
  }
}

void Batch::check_no_action(int first) const {
  require_started("step");
  if (options_.after_end == AfterEnd::kRefuse) refuse_ended(first);
}

void Batch::step(std::span<const float> actions) {
  check_actions(actions);
  step_all(actions.data());
}

void Batch::step(std::span<const float> actions, std::span<const std::uint8_t> commanded) {
  check_actions(actions);
  require_length("commanded", commanded.size(), static_cast<std::size_t>(num_envs()));
  if (rules_ != nullptr) {
    step_batch_task(actions.data(), commanded);
    return;
  }
  const auto moves = [&](int env) { return commanded[static_cast<std::size_t>(env)] != 0; };
  pool_.run(num_envs(), options_.chunk, [&](int worker, int begin, int end) {
    // Runs of neighbours that are alike.
    for (int env = begin; env < end;) {
      const int first = env;
      while (env < end && moves(env) == moves(first)) ++env;
      step_range(worker, {first, env}, moves(first) ? actions.data() : nullptr);
    }
  });
}

void Batch::step_no_action() {
  check_no_action();
  step_all(nullptr);
}

void Batch::step_all(const float* actions) {
  if (rules_ != nullptr) {
    step_batch_task(actions, {});
    return;
  }
  pool_.run(num_envs(), options_.chunk, [&](int worker, int begin, int end) {
    step_range(worker, {begin, end}, actions);
  });
}

// Environments whose episode has ended are reset or left alone, as the auto-reset mode says; the
// others are stepped in runs of neighbours, so that tasks get whole ranges.
void Batch::step_range(int worker, Range envs, const float* actions) {
  if (clock_ != nullptr) clock(worker)->start();
  int env = envs.begin;
  while (env < envs.end) {
    final_mask_[static_cast<std::size_t>(env)] = 0;
    if (waits(env)) {
      // With same-step resets, only an environment restored from another batch's snapshot can be
      // finished here.
      if (options_.auto_reset != AutoReset::kOff) {
        reset_env(worker, env, state_.seed[env], state_.episode[env] + 1);
        mark(clock(worker), StepPart::kReset);
        render_observation(worker, env);
      } else {
        reward_[env] = 0;
        if (images_) images_->repeat(env);
      }
      ++env;
      continue;
    }
    const int begin = env;
    for (; env < envs.end && !waits(env); ++env) {
      final_mask_[static_cast<std::size_t>(env)] = 0;
    }
    for (int first = begin; first < env; first += Simulator::kMaxTogether) {
      simulate(worker, {first, std::min(env, first + Simulator::kMaxTogether)}, actions);
    }
    finish_steps(worker, {begin, env});
  }
  copy_outputs(envs);
}

// Action, task, controller and physics of environments that move together.
void Batch::simulate(int worker, Range envs, const float* actions) {
  for (int env = envs.begin; env < envs.end; ++env) take_action(env, actions);
  mark(clock(worker), StepPart::kController);
  task_->before_physics(envs);
  mark(clock(worker), StepPart::kTask);
  run_physics(worker, envs, actions);
}

// Controller and physics of environments that move together.
void Batch::run_physics(int worker, Range envs, const float* actions) {
  StepClock::Worker* const time = clock(worker);
  std::array<DriveTarget, Simulator::kMaxTogether> drives;
  std::array<bool, Simulator::kMaxTogether> stable{};
  const std::span<DriveTarget> used(drives.data(), static_cast<std::size_t>(envs.end - envs.begin));
  if (commands_.delays()) {
    drive_by_queue(worker, envs, used);
  } else if (actions != nullptr) {
    controller_->drive(state_, envs.begin, bindings_.action, simulator_->block(worker), used);
  } else {
    for (int env = envs.begin; env < envs.end; ++env) {
      used[static_cast<std::size_t>(env - envs.begin)] =
          controller_->last_drive(state_, env, bindings_.action.row(env));
    }
  }
  mark(time, StepPart::kController);
  simulator_->step(state_, envs.begin, worker, used, stable.data(), time);
  for (int env = envs.begin; env < envs.end; ++env) {
    unstable_[env] = stable[static_cast<std::size_t>(env - envs.begin)] ? 0 : 1;
    if (unstable_[env] != 0) unstable_count_.fetch_add(1, std::memory_order_relaxed);
    if (state_.elapsed[env] < kMaxElapsed) ++state_.elapsed[env];
  }
  mark(time, StepPart::kGather);
  simulator_->update_tcp(state_, envs.begin, envs.end - envs.begin, worker);
  mark(time, StepPart::kObservation);
}

// Environments whose commands are late, one by one: some may have none to follow.
void Batch::drive_by_queue(int worker, Range envs, std::span<DriveTarget> drives) {
  for (int env = envs.begin; env < envs.end; ++env) {
    const auto place = static_cast<std::size_t>(env - envs.begin);
    if (commands_.follows(env)) {
      controller_->drive(state_, env, bindings_.action, simulator_->block(worker),
                         drives.subspan(place, 1));
    } else {
      drives[place] = controller_->last_drive(state_, env, bindings_.action.row(env));
    }
  }
}

// The action that an environment follows, and the one before. Without actions it is the same again.
void Batch::take_action(int env, const float* actions) {
  const auto dim = static_cast<std::size_t>(action_dim());
  float* current = bindings_.action.row(env);
  std::copy_n(current, dim, bindings_.previous_action.row(env));
  const float* given =
      actions == nullptr ? nullptr : actions + static_cast<std::ptrdiff_t>(env) * action_dim();
  if (commands_.is_used()) {
    const auto elapsed = static_cast<std::uint32_t>(state_.elapsed[env]);
    given = commands_.next(perturbations_, env, state_.elapsed[env], given,
                           noise_stream(env, kPurposeActionNoise + elapsed));
  }
  if (given == nullptr) return;
  if (options_.freeze_cue && state_.elapsed[env] < bindings_.freeze_steps[env]) {
    controller_->hold_action(state_, env, current);
  } else {
    std::copy_n(given, dim, current);
  }
}

// Everything after physics: phases, info, observation, reward, endings.
void Batch::finish_steps(int worker, Range envs) {
  StepClock::Worker* const time = clock(worker);
  task_->advance(envs);
  evaluate(envs);
  mark(time, StepPart::kTask);
  observe(envs);
  mark(time, StepPart::kObservation);
  compute_rewards(envs);
  for (int env = envs.begin; env < envs.end; ++env) {
    mark(time, StepPart::kTask);
    render_observation(worker, env);
    finish_step(worker, env);
  }
  mark(time, StepPart::kTask);
}

void Batch::evaluate(Range envs) {
  task_->evaluate(envs);
  if (!bindings_.strict) return;
  for (int env = envs.begin; env < envs.end; ++env) fail_wrong_answers(env);
}

// A wrong first answer fails the episode where users want that.
void Batch::fail_wrong_answers(int env) {
  if (!bindings_.answers.wrong(env)) return;
  bindings_.success[env] = 0;
  bindings_.failed[env] = 1;
}

// False if policies or learners would see NaN or infinity.
bool Batch::outputs_finite(int env) const {
  const auto all_finite = [](std::span<const float> values) {
    bool finite = true;
    for (const float value : values) {
      finite &= std::abs(value) <= std::numeric_limits<float>::max();  // false for NaN
    }
    return finite;
  };
  const auto row = [env](const Column<float>& column) {
    return std::span<const float>(column.row(env), static_cast<std::size_t>(column.width()));
  };
  return std::isfinite(reward_[env]) && all_finite(row(proprio_)) &&
         all_finite(objects_ ? objects_->robot_part(env) : row(observation_));
}

void Batch::finish_step(int worker, int env) {
  if (!end_step(env)) return;
  const float reward = reward_[env];
  const std::uint8_t flags[3] = {terminated_[env], truncated_[env], unstable_[env]};
  reset_env(worker, env, state_.seed[env], state_.episode[env] + 1);
  mark(clock(worker), StepPart::kReset);
  reward_[env] = reward;
  terminated_[env] = flags[0];
  truncated_[env] = flags[1];
  unstable_[env] = flags[2];
  render_observation(worker, env);
}

bool Batch::end_step(int env) {
  // Physics has checked its own columns. A snapshot may also hold NaN or infinity in the task's.
  if (!outputs_finite(env)) {
    if (unstable_[env] == 0) unstable_count_.fetch_add(1, std::memory_order_relaxed);
    unstable_[env] = 1;
    reward_[env] = 0;
  }
  const bool success = bindings_.success[env] != 0;
  success_once_[env] |= bindings_.success[env];
  episode_return_[env] += static_cast<double>(reward_[env]);

  const Termination rule = task_->info().termination;
  const bool ends_at_success = options_.terminate_on_success.value_or(rule != Termination::kNever);
  const bool ends_at_failure = options_.terminate_on_failure &&
                               rule == Termination::kSuccessOrFailed && bindings_.failed[env] != 0;
  terminated_[env] = ((success && ends_at_success) || ends_at_failure) ? 1 : 0;
  truncated_[env] = (state_.elapsed[env] >= task_->info().horizon || unstable_[env] != 0) ? 1 : 0;
  state_.finished[env] = terminated_[env] | truncated_[env];

  if (state_.finished[env] == 0 || options_.auto_reset != AutoReset::kSameStep) return false;
  // The new episode's outputs replace the old ones, except for reward and endings of this step.
  outputs_.copy_row_to(final_outputs_, env);
  if (images_) images_->keep_final(env);
  if (objects_) objects_->keep_final(env);
  final_mask_[static_cast<std::size_t>(env)] = 1;
  return true;
}

void Batch::draw_into(const ImageTargets& now, const ImageTargets& finals) {
  if (images_) images_->draw_into(now, finals);
}

void Batch::swap_to(const ImageTargets& now) {
  if (images_) images_->swap_to(now);
}

// Key of the sensors' noise in this step.
std::uint64_t Batch::image_noise_key(int env) const {
  constexpr std::uint64_t kNextStep = 0xd1b54a32d192ed03u;
  const auto elapsed = static_cast<std::uint64_t>(state_.elapsed[env]);
  return noise_stream(env, kPurposeImageNoise).next_u64() + elapsed * kNextStep;
}

void Batch::render_observation(int worker, int env) {
  if (!images_) return;
  if (perturbations_.change_images()) {
    const ImageChanges changes = perturbations_.images(env);
    images_->render(worker, state_, env, &changes, image_noise_key(env));
  } else {
    images_->render(worker, state_, env);
  }
  mark(clock(worker), StepPart::kRender);
}

}  // namespace engram
