#include "apps/record_episode.h"

#include <algorithm>

#include "protocol/eval/policies/choosing_policy.h"

namespace engram::apps {
namespace {

PolicyProcessOptions process_of(const EpisodeOptions& options, const Batch& batch) {
  return process_options(options.command, batch.options(), batch.num_envs());
}

}  // namespace

MakeOptions EpisodeOptions::observed() const {
  MakeOptions observed = env;
  observed.obs_mode = obs.value_or(ObsMode::kRgb);
  observed.image_options = {};
  observed.image_options.renderer = env.image_options.renderer;
  return observed;
}

// --- an external policy ---

CommandPolicy::CommandPolicy(const EpisodeOptions& options, const std::atomic<bool>& stopped)
    : context_(0, stopped, env_steps_),
      batch_(make(options.id, options.observed())),
      process_(process_of(options, *batch_), context_),
      actor_(make_external_actor(
          *batch_, process_, context_,
          {options.command.tell_episodes, options.run.policy_seed, options.run.latency},
          options.command.choices ? options.command.choices_stride : 0)) {
  batch_->reset();
  const std::uint64_t seed = batch_->options().seed;
  actor_->start(0, label_episode(0, batch_->info().id, seed, {}, options.command.tell_episodes));
}

void CommandPolicy::act(std::span<float> actions, std::span<std::uint8_t> commanded) {
  actor_->act(actions, commanded);
  batch_->step(actions, commanded);
}

// --- the episode ---

RecordedEpisode::RecordedEpisode(const EpisodeOptions& options, const Interruption& interruption)
    : interruption_(interruption),
      max_steps_(options.steps),
      batch_(make(options.id, options.env)) {
  const int horizon = batch_->info().horizon;
  max_steps_ = max_steps_ == 0 ? horizon : std::min(max_steps_, horizon);
  rewind();
  if (options.command.given()) {
    command_policy_.emplace(options, interruption.flag());
  } else {
    own_policy_.emplace(*batch_, options.policy, options.run.latency);
    own_policy_->start(0, {});
  }
}

bool RecordedEpisode::over() const {
  return steps() >= max_steps_ ||
         (batch_->outputs().terminated[0] | batch_->outputs().truncated[0]) != 0;
}

void RecordedEpisode::step() {
  interruption_.check("nothing was written");
  const auto now = static_cast<std::size_t>(steps());
  if (now == actions_.size()) {
    Action action{std::vector<float>(static_cast<std::size_t>(batch_->action_dim())), {}};
    if (command_policy_) {
      command_policy_->act(action.values, action.commanded);
    } else {
      own_policy_->act(action.values, action.commanded);
    }
    actions_.push_back(std::move(action));
  }
  batch_->step(actions_[now].values, actions_[now].commanded);
  if (command_policy_ && over()) command_policy_->check_no_pending_reply();
}

void RecordedEpisode::rewind() {
  const std::uint64_t seed = batch_->options().seed;
  batch_->reset({.mask = {}, .seeds = {&seed, 1}, .pins = nullptr, .constants = nullptr});
}

}  // namespace engram::apps
