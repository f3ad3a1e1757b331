#include "protocol/eval/probe/trial_player.h"

#include <algorithm>

#include "core/batch/snapshot.h"
#include "protocol/make/rows.h"

namespace engram {
namespace {

bool has_ended(const Batch& batch, int env) { return batch.state().finished[env] != 0; }

// The first answer, where the task asks for one.
void read_answer(const Batch& batch, int env, std::uint8_t& answered, std::int32_t& answer) {
  if (batch.info().answer.empty()) return;
  answered = value_of<std::uint8_t>(batch.output("answered"), env);
  answer = value_of<std::int32_t>(batch.output("first_answer"), env);
}

}  // namespace

TrialPlayer::TrialPlayer(const PolicyBatch& main, const PolicyBatch& other, Labeller label)
    : main_(main),
      other_(other),
      label_(std::move(label)),
      cue_policy_(*main.batch),
      states_(static_cast<std::size_t>(main.batch->num_envs())) {}

void TrialPlayer::play(std::span<const Trial> trials, std::span<const std::uint32_t> sizes,
                       const WorkContext& context, const TakeGroup& take) {
  trials_ = trials;
  take_ = take;
  groups_.clear();
  group_of_.clear();
  for (const std::uint32_t size : sizes) {
    const std::size_t first = group_of_.size();
    group_of_.insert(group_of_.end(), size, groups_.size());
    groups_.push_back({first, group_of_.size(), size});
  }
  results_.assign(trials.size(), {});
  presents_.assign(trials.size(), {});
  done_ = 0;
  std::size_t started = 0;
  main_.batch->reset();
  if (!shares_batch()) other_.batch->reset();
  while (done_ < trials.size()) {
    if (context.stopped()) return;
    const std::uint64_t busy = fill_slots(started);
    act_and_step(main_, false);
    if (!shares_batch()) act_and_step(other_, true);
    context.count_env_steps(busy);
    for (int env = 0; env < static_cast<int>(states_.size()); ++env) after_step(env);
  }
}

// Begins trials in idle slots; returns the number of busy ones.
std::uint64_t TrialPlayer::fill_slots(std::size_t& started) {
  std::uint64_t busy = 0;
  for (std::size_t env = 0; env < states_.size(); ++env) {
    while (states_[env].phase == TrialState::Phase::kIdle && started < trials_.size()) {
      begin(static_cast<int>(env), started++);
    }
    busy += states_[env].phase == TrialState::Phase::kIdle ? 0 : 1;
  }
  return busy;
}

void TrialPlayer::finish(std::size_t trial) {
  ++done_;
  const std::size_t number = group_of_[trial];
  Group& group = groups_[number];
  if (--group.left > 0) return;
  compare_presents(group.first, group.end);
  take_(number, std::span(results_).subspan(group.first, group.end - group.first));
}

void TrialPlayer::compare_presents(std::size_t first, std::size_t end) {
  for (std::size_t i = first; i < end; ++i) {
    const int twin = trials_[i].twin;
    const bool same = twin >= 0 && !presents_[i].empty() &&
                      presents_[i] == presents_[static_cast<std::size_t>(twin)];
    results_[i].compared = twin >= 0 && results_[i].played != 0 ? 1 : 0;
    results_[i].same_present = same ? 1 : 0;
  }
}

void TrialPlayer::begin_episode(const PolicyBatch& batch, int env, const EpisodeDraw& draw) {
  const auto size = static_cast<std::size_t>(batch.batch->num_envs());
  std::vector<std::uint8_t> mask(size);
  std::vector<std::uint64_t> seeds(size);
  mask[static_cast<std::size_t>(env)] = 1;
  seeds[static_cast<std::size_t>(env)] = draw.seed;
  batch.batch->reset({.mask = mask, .seeds = seeds, .pins = &draw.pins});
}

void TrialPlayer::begin(int env, std::size_t trial) {
  TrialState& state = states_[static_cast<std::size_t>(env)];
  if (trials_[trial].question < 0) return finish(trial);
  begin_episode(main_, env, trials_[trial].draw);
  main_.actor->start(env, label_(trial));
  cue_policy_.begin(env);
  state = {TrialState::Phase::kCue, trial, 0, {}};
  if (trials_[trial].question == 0) reach_question(env);
}

void TrialPlayer::reach_question(int env) {
  TrialState& state = states_[static_cast<std::size_t>(env)];
  const Trial& trial = trials_[state.trial];
  results_[state.trial].played = 1;
  results_[state.trial].exchanged = trial.scene ? 1 : 0;
  cue_policy_.end(env);
  if (trial.scene) Snapshotter(*main_.batch).restore(env, *trial.scene);
  presents_[state.trial] = visible_state(*main_.batch, env);
  // Actions that were chosen while the cue showed would carry it past the question.
  if (trial.wiped) {
    main_.actor->start(env, label_(state.trial));
  } else {
    main_.actor->replace_scene(env, label_(state.trial));
  }
  state.phase = TrialState::Phase::kFree;
  if (trial.others.empty()) return;
  state.paused = Snapshotter(*main_.batch).save(env);
  main_.actor->finish(env);
  begin_other(env);
}

void TrialPlayer::begin_other(int env) {
  TrialState& state = states_[static_cast<std::size_t>(env)];
  state.phase = TrialState::Phase::kOther;
  begin_episode(other_, env, trials_[state.trial].others[state.others++]);
  other_.actor->replace_scene(env, label_(state.trial));
}

void TrialPlayer::resume(int env) {
  TrialState& state = states_[static_cast<std::size_t>(env)];
  Snapshotter(*main_.batch).restore(env, state.paused);
  state.paused.clear();
  state.phase = TrialState::Phase::kFree;
  main_.actor->replace_scene(env, label_(state.trial));
}

// other: the batch is that of the episodes between, and only of those.
void TrialPlayer::act_and_step(const PolicyBatch& batch, bool other) {
  const auto busy = [&](int env) {
    const TrialState::Phase phase = states_[static_cast<std::size_t>(env)].phase;
    if (phase == TrialState::Phase::kIdle) return false;
    return shares_batch() || (phase == TrialState::Phase::kOther) == other;
  };
  const int envs = static_cast<int>(states_.size());
  bool any = false;
  for (int env = 0; env < envs; ++env) any |= busy(env);
  if (!any) return;
  actions_.resize(states_.size() * static_cast<std::size_t>(batch.batch->action_dim()));
  commanded_.assign(states_.size(), 1);
  batch.actor->act(actions_, commanded_);
  showing_.clear();
  for (int env = 0; env < envs; ++env) {
    const auto i = static_cast<std::size_t>(env);
    if (!busy(env)) commanded_[i] = 0;
    if (busy(env) && states_[i].phase == TrialState::Phase::kCue) showing_.push_back(env);
  }
  if (!showing_.empty()) cue_policy_.act(showing_, actions_, commanded_);
  batch.batch->step(actions_, commanded_);
}

void TrialPlayer::after_step(int env) {
  TrialState& state = states_[static_cast<std::size_t>(env)];
  if (state.phase == TrialState::Phase::kIdle) return;
  if (state.phase == TrialState::Phase::kOther) {
    if (has_ended(*other_.batch, env)) end_other(env);
    return;
  }
  const Trial& trial = trials_[state.trial];
  if (has_ended(*main_.batch, env)) return end(env);
  if (state.phase == TrialState::Phase::kCue) {
    if (main_.batch->state().elapsed[env] >= trial.question) reach_question(env);
    return;
  }
  if (!trial.until_answer) return;
  std::uint8_t answered = 0;
  std::int32_t answer = 0;
  read_answer(*main_.batch, env, answered, answer);
  if (answered != 0) end(env);
}

void TrialPlayer::end_other(int env) {
  const TrialState& state = states_[static_cast<std::size_t>(env)];
  TrialResult& result = results_[state.trial];
  read_answer(*other_.batch, env, result.other_answered, result.other_answer);
  if (state.others < trials_[state.trial].others.size()) return begin_other(env);
  other_.actor->finish(env);
  resume(env);
}

void TrialPlayer::end(int env) {
  TrialState& state = states_[static_cast<std::size_t>(env)];
  TrialResult& result = results_[state.trial];
  const Batch& batch = *main_.batch;
  result.success = value_of<std::uint8_t>(batch.output("success_once"), env);
  read_answer(batch, env, result.answered, result.answer);
  if (result.answered != 0) {
    result.correct = value_of<std::uint8_t>(batch.output("first_answer_correct"), env);
  }
  main_.actor->finish(env);
  const std::size_t trial = state.trial;
  state = {};
  finish(trial);
}

}  // namespace engram
