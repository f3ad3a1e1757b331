// Stages of a step or reset.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/batch/batch_data.h"

namespace engram {
namespace {

// begin generated: pose (tools/surface, from api/surface.toml)
// Rest pose of arm and fingers, rad and m.
inline constexpr std::array<double, 9> kRest = {
    0,    0,   0, -2 * std::numbers::pi / 3, 0, 2 * std::numbers::pi / 3, std::numbers::pi / 4,
    0.04, 0.04};
// end generated

}  // namespace

void BatchData::choose_resets(Range envs, const CheckedReset& reset) {
  for (int env = envs.begin; env < envs.end; ++env) {
    const bool begins = reset.request.selects(env);
    stages[at(env)] = begins ? EnvStage::kBeginning : EnvStage::kHeld;
    if (begins) final_mask[at(env)] = 0;
  }
}

// An environment whose episode has ended is reset or left alone, as the auto-reset mode says. With
// same-step resets, only one restored from another batch's snapshot can be finished here.
void BatchData::begin_step(int worker, Range envs, const StepActions& actions) {
  for (int env = envs.begin; env < envs.end; ++env) {
    final_mask[at(env)] = 0;
    if (!is_done(env)) {
      stages[at(env)] = EnvStage::kStepping;
      take_action(env, actions.has(env) ? actions.values : nullptr);
    } else if (options.auto_reset != AutoReset::kOff) {
      stages[at(env)] = EnvStage::kBeginning;
    } else {
      stages[at(env)] = EnvStage::kHeld;
      reward[env] = 0;
      if (images) images->repeat(env);
    }
  }
  mark(clock(worker), StepPart::kController);
}

// Neighbours that are alike move together.
void BatchData::simulate_active(int worker, Range envs, const StepActions& actions) {
  for_runs(envs, EnvStage::kStepping, [&](Range run) {
    for (int env = run.begin; env < run.end;) {
      const int first = env;
      const int end = std::min(run.end, first + PhysicsEngine::kMaxTogether);
      while (env < end && actions.has(env) == actions.has(first)) ++env;
      run_physics(worker, {first, env}, actions.has(first) ? actions.values : nullptr);
    }
  });
}

// Controller and physics of environments that move together.
void BatchData::run_physics(int worker, Range envs, const float* actions) {
  StepClock::Worker* const time = clock(worker);
  std::array<DriveTarget, PhysicsEngine::kMaxTogether> drives;
  std::array<bool, PhysicsEngine::kMaxTogether> stable{};
  const std::span<DriveTarget> used(drives.data(), at(envs.end - envs.begin));
  if (commands.delays()) {
    drive_by_queue(worker, envs, used);
  } else if (actions != nullptr) {
    controller->drive(state, envs.begin, bindings.action, simulator->block(worker), used);
  } else {
    for (int env = envs.begin; env < envs.end; ++env) {
      used[at(env - envs.begin)] = controller->last_drive(state, env, bindings.action.row(env));
    }
  }
  mark(time, StepPart::kController);
  physics().step(state, envs.begin, worker, used, stable.data(), time);
  for (int env = envs.begin; env < envs.end; ++env) {
    unstable[env] = stable[at(env - envs.begin)] ? 0 : 1;
    if (unstable[env] != 0) unstable_count.fetch_add(1, std::memory_order_relaxed);
    if (state.elapsed[env] < kMaxElapsed) ++state.elapsed[env];
  }
  mark(time, StepPart::kGather);
  simulator->update_tcp(state, envs.begin, envs.end - envs.begin, worker);
  mark(time, StepPart::kObservation);
}

// Environments whose commands are late, one by one: some may have none to follow.
void BatchData::drive_by_queue(int worker, Range envs, std::span<DriveTarget> drives) {
  for (int env = envs.begin; env < envs.end; ++env) {
    const auto place = at(env - envs.begin);
    if (commands.follows(env)) {
      controller->drive(state, env, bindings.action, simulator->block(worker),
                        drives.subspan(place, 1));
    } else {
      drives[place] = controller->last_drive(state, env, bindings.action.row(env));
    }
  }
}

// The action that an environment follows, and the one before. Without actions it is the same again.
void BatchData::take_action(int env, const float* actions) {
  const auto dim = at(action_dim());
  float* current = bindings.action.row(env);
  std::copy_n(current, dim, bindings.previous_action.row(env));
  const float* given =
      actions == nullptr ? nullptr : actions + static_cast<std::ptrdiff_t>(env) * action_dim();
  if (commands.is_used()) {
    const auto elapsed = static_cast<std::uint32_t>(state.elapsed[env]);
    given = commands.next(perturbations, env, state.elapsed[env], given,
                          noise_stream(env, kPurposeActionNoise + elapsed));
  }
  if (given == nullptr) return;
  if (options.freeze_cue && state.elapsed[env] < bindings.freeze_steps[env]) {
    controller->hold_action(state, env, current);
  } else {
    std::copy_n(given, dim, current);
  }
}

void BatchData::finish(int worker, Range envs) {
  StepClock::Worker* const time = clock(worker);
  for_runs(envs, EnvStage::kStepping, [&](Range run) {
    for (int env = run.begin; env < run.end; ++env) {
      observe_robot(env);
      mark(time, StepPart::kObservation);
      scale_reward(env);
      render(worker, env);
      if (end_step(env)) stages[at(env)] = EnvStage::kBeginning;
      mark(time, StepPart::kTask);
    }
  });
}

// From the dense reward, where the mode has it.
void BatchData::scale_reward(int env) {
  switch (options.reward_mode) {
    case RewardMode::kNone:
      reward[env] = 0;
      break;
    case RewardMode::kSparse:
      reward[env] = bindings.success[env] != 0 ? 1.0F : 0.0F;
      break;
    case RewardMode::kDense:
      break;
    case RewardMode::kNormalizedDense:
      reward[env] /= static_cast<float>(task->info().success_reward);
      break;
  }
}

void BatchData::fail_wrong_answers(Range envs) {
  for (int env = envs.begin; env < envs.end; ++env) fail_wrong_answer(env);
}

void BatchData::fail_wrong_answers(std::span<const int> envs) {
  for (const int env : envs) fail_wrong_answer(env);
}

// A wrong first answer fails the episode where users want that.
void BatchData::fail_wrong_answer(int env) {
  if (!bindings.answers.wrong(env)) return;
  bindings.success[env] = 0;
  bindings.failed[env] = 1;
}

// False if policies or learners would see NaN or infinity.
bool BatchData::outputs_finite(int env) const {
  const auto all_finite = [](std::span<const float> values) {
    bool finite = true;
    for (const float value : values) {
      finite &= std::abs(value) <= std::numeric_limits<float>::max();  // false for NaN
    }
    return finite;
  };
  const auto row = [env](const Column<float>& column) {
    return std::span<const float>(column.row(env), at(column.width()));
  };
  return std::isfinite(reward[env]) && all_finite(row(proprio)) &&
         all_finite(objects ? objects->robot_part(env) : row(observation));
}

// True if the outputs are kept because a new episode replaces them at once.
bool BatchData::end_step(int env) {
  // Physics has checked its own columns. A snapshot may also hold NaN or infinity in the task's.
  if (!outputs_finite(env)) {
    if (unstable[env] == 0) unstable_count.fetch_add(1, std::memory_order_relaxed);
    unstable[env] = 1;
    reward[env] = 0;
  }
  const bool success = bindings.success[env] != 0;
  success_once[env] |= bindings.success[env];
  episode_return[env] += static_cast<double>(reward[env]);

  const Termination rule = task->info().termination;
  const bool ends_at_success = options.terminate_on_success.value_or(rule != Termination::kNever);
  const bool ends_at_failure = options.terminate_on_failure &&
                               rule == Termination::kSuccessOrFailed && bindings.failed[env] != 0;
  terminated[env] = ((success && ends_at_success) || ends_at_failure) ? 1 : 0;
  truncated[env] = (state.elapsed[env] >= task->info().horizon || unstable[env] != 0) ? 1 : 0;
  state.finished[env] = terminated[env] | truncated[env];

  if (state.finished[env] == 0 || options.auto_reset != AutoReset::kSameStep) return false;
  // The new episode's outputs replace the old ones, except for reward and endings of this step.
  outputs.copy_row_to(final_outputs, env);
  if (images) images->keep_final(env);
  if (objects) objects->keep_final(env);
  final_mask[at(env)] = 1;
  return true;
}

void BatchData::begin_episodes(int worker, Range envs, const CheckedReset* reset) {
  for_runs(envs, EnvStage::kBeginning, [&](Range run) {
    for (int env = run.begin; env < run.end; ++env) {
      const auto [seed, number] = next_episode(env, reset);
      if (reset != nullptr && reset->pins != nullptr) pins.set(env, *reset->pins);
      if (reset != nullptr && reset->request.constants != nullptr) pins.narrow(env, reset->ranges);
      const float last_reward = reward[env];
      const std::uint8_t flags[3] = {terminated[env], truncated[env], unstable[env]};
      begin_episode(worker, env, seed, number);
      if (final_mask[at(env)] == 0) continue;
      reward[env] = last_reward;
      terminated[env] = flags[0];
      truncated[env] = flags[1];
      unstable[env] = flags[2];
    }
  });
  mark(clock(worker), StepPart::kReset);
}

// Seed and number.
std::pair<std::uint64_t, std::uint64_t> BatchData::next_episode(int env,
                                                                const CheckedReset* reset) const {
  if (reset != nullptr && !reset->request.seeds.empty()) return {reset->request.seeds[at(env)], 0};
  if (started) return {state.seed[env], state.episode[env] + 1};
  return {options.seed + static_cast<std::uint64_t>(env), 0};
}

// The robot stands, and the task has sampled.
void BatchData::begin_episode(int worker, int env, std::uint64_t seed, std::uint64_t number) {
  memory.clear_row(env);
  outputs.clear_row(env);
  state.seed[env] = seed;
  state.episode[env] = number;

  const Episode episode(pins, env, bindings.stream_key(env), number);
  perturbations.draw(episode);
  double* qpos = state.qpos.row(env);
  std::copy(kRest.begin(), kRest.end(), qpos);
  const double* pinned_noise = pins.values(env, 0);
  RandomStream noise = episode.engine_stream(kPurposeRobotNoise);
  for (int i = 0; i < kArmJoints; ++i) {
    qpos[i] +=
        pinned_noise != nullptr ? pinned_noise[i] : options.robot_init_qpos_noise * noise.normal();
    qpos[i] += perturbations.start_pose(env, i);
  }
  simulator->update_tcp(state, env, 1, worker);
  controller->reset(state, env);

  task->reset(episode);
}

std::span<const int> BatchData::listed(EnvStage stage) {
  list.clear();
  for (int env = 0; env < num_envs(); ++env) {
    if (stages[at(env)] == stage) list.push_back(env);
  }
  return list;
}

void BatchData::show_beginning(int worker, Range envs) {
  for_runs(envs, EnvStage::kBeginning, [&](Range run) {
    for (int env = run.begin; env < run.end; ++env) {
      observe_robot(env);
      mark(clock(worker), StepPart::kReset);
      render(worker, env);
    }
  });
  copy_outputs(envs);
}

}  // namespace engram
