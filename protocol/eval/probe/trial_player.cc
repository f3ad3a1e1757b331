#include "protocol/eval/probe/trial_player.h"

#include <algorithm>

#include "core/batch/snapshot.h"
#include "protocol/make/rows.h"

namespace engram {
namespace {

bool has_ended(const Batch& env, int slot) { return env.state().finished[slot] != 0; }

// The first answer, where the task asks for one.
void read_answer(const Batch& env, int slot, std::uint8_t& answered, std::int32_t& answer) {
  if (env.info().answer.empty()) return;
  answered = value_of<std::uint8_t>(env.output("answered"), slot);
  answer = value_of<std::int32_t>(env.output("first_answer"), slot);
}

}  // namespace

TrialPlayer::TrialPlayer(const PolicyBatch& main, const PolicyBatch& other, Labeller label)
    : main_(main),
      other_(other),
      label_(std::move(label)),
      cue_policy_(*main.env),
      states_(static_cast<std::size_t>(main.env->num_envs())) {}

std::vector<TrialResult> TrialPlayer::play(std::span<const Trial> trials,
                                           const WorkContext& context) {
  trials_ = trials;
  results_.assign(trials.size(), {});
  presents_.assign(trials.size(), {});
  done_ = 0;
  std::size_t started = 0;
  main_.env->reset();
  if (!shares_batch()) other_.env->reset();
  while (done_ < trials.size()) {
    if (context.stopped()) return {};
    const std::uint64_t busy = fill_slots(started);
    act_and_step(main_, false);
    if (!shares_batch()) act_and_step(other_, true);
    context.count_env_steps(busy);
    for (int slot = 0; slot < static_cast<int>(states_.size()); ++slot) after_step(slot);
  }
  compare_presents();
  return std::move(results_);
}

// Begins trials in idle slots; returns the number of busy ones.
std::uint64_t TrialPlayer::fill_slots(std::size_t& started) {
  std::uint64_t busy = 0;
  for (std::size_t slot = 0; slot < states_.size(); ++slot) {
    while (states_[slot].phase == TrialState::Phase::kIdle && started < trials_.size()) {
      begin(static_cast<int>(slot), started++);
    }
    busy += states_[slot].phase == TrialState::Phase::kIdle ? 0 : 1;
  }
  return busy;
}

void TrialPlayer::compare_presents() {
  for (std::size_t i = 0; i < trials_.size(); ++i) {
    const int twin = trials_[i].twin;
    const bool same = twin >= 0 && !presents_[i].empty() &&
                      presents_[i] == presents_[static_cast<std::size_t>(twin)];
    results_[i].compared = twin >= 0 && results_[i].played != 0 ? 1 : 0;
    results_[i].same_present = same ? 1 : 0;
  }
}

void TrialPlayer::begin_episode(const PolicyBatch& batch, int slot, const EpisodeDraw& draw) {
  const auto size = static_cast<std::size_t>(batch.env->num_envs());
  std::vector<std::uint8_t> mask(size);
  std::vector<std::uint64_t> seeds(size);
  mask[static_cast<std::size_t>(slot)] = 1;
  seeds[static_cast<std::size_t>(slot)] = draw.seed;
  batch.env->reset({.mask = mask, .seeds = seeds, .pins = &draw.pins});
}

void TrialPlayer::begin(int slot, std::size_t trial) {
  TrialState& state = states_[static_cast<std::size_t>(slot)];
  if (trials_[trial].question < 0) {
    ++done_;
    return;
  }
  begin_episode(main_, slot, trials_[trial].draw);
  main_.actor->start(slot, label_(trial));
  cue_policy_.begin(slot);
  state = {TrialState::Phase::kCue, trial, 0, {}};
  if (trials_[trial].question == 0) reach_question(slot);
}

void TrialPlayer::reach_question(int slot) {
  TrialState& state = states_[static_cast<std::size_t>(slot)];
  const Trial& trial = trials_[state.trial];
  results_[state.trial].played = 1;
  results_[state.trial].exchanged = trial.scene ? 1 : 0;
  cue_policy_.end(slot);
  if (trial.scene) Snapshotter(*main_.env).restore(slot, *trial.scene);
  presents_[state.trial] = present_of(*main_.env, slot);
  // Actions that were chosen while the cue showed would carry it past the question.
  if (trial.wiped) {
    main_.actor->start(slot, label_(state.trial));
  } else {
    main_.actor->go_on(slot, label_(state.trial));
  }
  state.phase = TrialState::Phase::kFree;
  if (trial.others.empty()) return;
  state.paused = Snapshotter(*main_.env).save(slot);
  main_.actor->finish(slot);
  begin_other(slot);
}

void TrialPlayer::begin_other(int slot) {
  TrialState& state = states_[static_cast<std::size_t>(slot)];
  state.phase = TrialState::Phase::kOther;
  begin_episode(other_, slot, trials_[state.trial].others[state.others++]);
  other_.actor->go_on(slot, label_(state.trial));
}

void TrialPlayer::resume(int slot) {
  TrialState& state = states_[static_cast<std::size_t>(slot)];
  Snapshotter(*main_.env).restore(slot, state.paused);
  state.paused.clear();
  state.phase = TrialState::Phase::kFree;
  main_.actor->go_on(slot, label_(state.trial));
}

// other: the batch is that of the episodes between, and only of those.
void TrialPlayer::act_and_step(const PolicyBatch& batch, bool other) {
  const auto busy = [&](int slot) {
    const TrialState::Phase phase = states_[static_cast<std::size_t>(slot)].phase;
    if (phase == TrialState::Phase::kIdle) return false;
    return shares_batch() || (phase == TrialState::Phase::kOther) == other;
  };
  const int slots = static_cast<int>(states_.size());
  bool any = false;
  for (int slot = 0; slot < slots; ++slot) any |= busy(slot);
  if (!any) return;
  actions_.resize(states_.size() * static_cast<std::size_t>(batch.env->action_dim()));
  commanded_.assign(states_.size(), 1);
  batch.actor->act(actions_, commanded_);
  showing_.clear();
  for (int slot = 0; slot < slots; ++slot) {
    const auto i = static_cast<std::size_t>(slot);
    if (!busy(slot)) commanded_[i] = 0;
    if (busy(slot) && states_[i].phase == TrialState::Phase::kCue) showing_.push_back(slot);
  }
  if (!showing_.empty()) cue_policy_.act(showing_, actions_, commanded_);
  batch.env->step(actions_, commanded_);
}

void TrialPlayer::after_step(int slot) {
  TrialState& state = states_[static_cast<std::size_t>(slot)];
  if (state.phase == TrialState::Phase::kIdle) return;
  if (state.phase == TrialState::Phase::kOther) {
    if (has_ended(*other_.env, slot)) end_other(slot);
    return;
  }
  const Trial& trial = trials_[state.trial];
  if (has_ended(*main_.env, slot)) return end(slot);
  if (state.phase == TrialState::Phase::kCue) {
    if (main_.env->state().elapsed[slot] >= trial.question) reach_question(slot);
    return;
  }
  if (!trial.until_answer) return;
  std::uint8_t answered = 0;
  std::int32_t answer = 0;
  read_answer(*main_.env, slot, answered, answer);
  if (answered != 0) end(slot);
}

void TrialPlayer::end_other(int slot) {
  const TrialState& state = states_[static_cast<std::size_t>(slot)];
  TrialResult& result = results_[state.trial];
  read_answer(*other_.env, slot, result.other_answered, result.other_answer);
  if (state.others < trials_[state.trial].others.size()) return begin_other(slot);
  other_.actor->finish(slot);
  resume(slot);
}

void TrialPlayer::end(int slot) {
  TrialState& state = states_[static_cast<std::size_t>(slot)];
  TrialResult& result = results_[state.trial];
  const Batch& env = *main_.env;
  result.success = value_of<std::uint8_t>(env.output("success_once"), slot);
  read_answer(env, slot, result.answered, result.answer);
  if (result.answered != 0) {
    result.correct = value_of<std::uint8_t>(env.output("first_answer_correct"), slot);
  }
  main_.actor->finish(slot);
  state = {};
  ++done_;
}

}  // namespace engram
