#include "protocol/probe/trial_player.h"

#include <algorithm>

#include "core/env/snapshot.h"
#include "protocol/batch/rows.h"

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

TrialPlayer::TrialPlayer(const ProbeStage& main, const ProbeStage& other, Labeller label)
    : main_(main),
      other_(other),
      label_(std::move(label)),
      prologue_(*main.env),
      courses_(static_cast<std::size_t>(main.env->num_envs())) {}

std::vector<TrialResult> TrialPlayer::play(std::span<const Trial> trials,
                                           const WorkContext& context) {
  trials_ = trials;
  results_.assign(trials.size(), {});
  presents_.assign(trials.size(), {});
  done_ = 0;
  std::size_t started = 0;
  main_.env->reset();
  if (!shares_stage()) other_.env->reset();
  while (done_ < trials.size()) {
    if (context.stopped()) return {};
    std::uint64_t busy = 0;
    for (std::size_t slot = 0; slot < courses_.size(); ++slot) {
      while (courses_[slot].part == Course::Part::kNone && started < trials.size()) {
        begin(static_cast<int>(slot), started++);
      }
      busy += courses_[slot].part == Course::Part::kNone ? 0 : 1;
    }
    act_and_step(main_, false);
    if (!shares_stage()) act_and_step(other_, true);
    context.count_env_steps(busy);
    for (int slot = 0; slot < static_cast<int>(courses_.size()); ++slot) after_step(slot);
  }
  for (std::size_t i = 0; i < trials.size(); ++i) {
    const int twin = trials[i].twin;
    const bool same = twin >= 0 && !presents_[i].empty() &&
                      presents_[i] == presents_[static_cast<std::size_t>(twin)];
    results_[i].same_present = same ? 1 : 0;
  }
  return std::move(results_);
}

void TrialPlayer::begin_episode(const ProbeStage& stage, int slot, const EpisodeDraw& draw) {
  const auto size = static_cast<std::size_t>(stage.env->num_envs());
  std::vector<std::uint8_t> mask(size);
  std::vector<std::uint64_t> seeds(size);
  mask[static_cast<std::size_t>(slot)] = 1;
  seeds[static_cast<std::size_t>(slot)] = draw.seed;
  stage.env->reset({.mask = mask, .seeds = seeds, .pins = &draw.pins});
}

void TrialPlayer::begin(int slot, std::size_t trial) {
  Course& course = courses_[static_cast<std::size_t>(slot)];
  if (trials_[trial].question < 0) {
    ++done_;
    return;
  }
  begin_episode(main_, slot, trials_[trial].draw);
  main_.actor->start(slot, label_(trial));
  const bool waits = trials_[trial].question > 0;
  course = {waits ? Course::Part::kPrologue : Course::Part::kFree, trial, 0, {}};
  if (!waits) results_[trial].played = 1;
}

void TrialPlayer::reach_question(int slot) {
  Course& course = courses_[static_cast<std::size_t>(slot)];
  const Trial& trial = trials_[course.trial];
  results_[course.trial].played = 1;
  if (trial.scene) Snapshotter(*main_.env).restore(slot, *trial.scene);
  presents_[course.trial] = present_of(*main_.env, slot);
  if (trial.wiped) main_.actor->start(slot, label_(course.trial));
  course.part = Course::Part::kFree;
  if (trial.others.empty()) return;
  course.paused = Snapshotter(*main_.env).save(slot);
  main_.actor->finish(slot);
  begin_other(slot);
}

void TrialPlayer::begin_other(int slot) {
  Course& course = courses_[static_cast<std::size_t>(slot)];
  course.part = Course::Part::kOther;
  begin_episode(other_, slot, trials_[course.trial].others[course.others++]);
  other_.actor->go_on(slot, label_(course.trial));
}

void TrialPlayer::resume(int slot) {
  Course& course = courses_[static_cast<std::size_t>(slot)];
  Snapshotter(*main_.env).restore(slot, course.paused);
  course.paused.clear();
  course.part = Course::Part::kFree;
  main_.actor->go_on(slot, label_(course.trial));
}

// other: the stage is that of the episodes between, and only of those.
void TrialPlayer::act_and_step(const ProbeStage& stage, bool other) {
  const auto busy = [&](int slot) {
    const Course::Part part = courses_[static_cast<std::size_t>(slot)].part;
    if (part == Course::Part::kNone) return false;
    return shares_stage() || (part == Course::Part::kOther) == other;
  };
  const int slots = static_cast<int>(courses_.size());
  bool any = false;
  for (int slot = 0; slot < slots; ++slot) any |= busy(slot);
  if (!any) return;
  actions_.resize(courses_.size() * static_cast<std::size_t>(stage.env->action_dim()));
  commanded_.assign(courses_.size(), 1);
  stage.actor->act(actions_, commanded_);
  for (int slot = 0; slot < slots; ++slot) {
    if (!busy(slot)) {
      commanded_[static_cast<std::size_t>(slot)] = 0;
    } else if (courses_[static_cast<std::size_t>(slot)].part == Course::Part::kPrologue) {
      prologue_.act(slot, actions_, commanded_);
    }
  }
  stage.env->step(actions_, commanded_);
}

void TrialPlayer::after_step(int slot) {
  Course& course = courses_[static_cast<std::size_t>(slot)];
  if (course.part == Course::Part::kNone) return;
  if (course.part == Course::Part::kOther) {
    if (has_ended(*other_.env, slot)) end_other(slot);
    return;
  }
  const Trial& trial = trials_[course.trial];
  if (has_ended(*main_.env, slot)) return end(slot);
  if (course.part == Course::Part::kPrologue) {
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
  const Course& course = courses_[static_cast<std::size_t>(slot)];
  TrialResult& result = results_[course.trial];
  read_answer(*other_.env, slot, result.other_answered, result.other_answer);
  if (course.others < trials_[course.trial].others.size()) return begin_other(slot);
  other_.actor->finish(slot);
  resume(slot);
}

void TrialPlayer::end(int slot) {
  Course& course = courses_[static_cast<std::size_t>(slot)];
  TrialResult& result = results_[course.trial];
  const Batch& env = *main_.env;
  result.success = value_of<std::uint8_t>(env.output("success_once"), slot);
  read_answer(env, slot, result.answered, result.answer);
  if (result.answered != 0) {
    result.correct = value_of<std::uint8_t>(env.output("first_answer_correct"), slot);
  }
  main_.actor->finish(slot);
  course = {};
  ++done_;
}

}  // namespace engram
