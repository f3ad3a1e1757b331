#include "apps/episode_log.h"

#include "protocol/make/rows.h"

namespace engram::apps {

EpisodeLog::EpisodeLog(const Batch& batch, int episodes)
    : wanted_(episodes),
      finished_(static_cast<std::size_t>(batch.num_envs()), 0),
      quota_(static_cast<std::size_t>(batch.num_envs()), std::numeric_limits<std::int32_t>::max()),
      moving_(batch.num_envs()) {
  if (episodes == 0) return;
  for (int i = 0; i < batch.num_envs(); ++i) {
    const int extra = i < episodes % batch.num_envs() ? 1 : 0;
    quota_[static_cast<std::size_t>(i)] = episodes / batch.num_envs() + extra;
  }
}

void EpisodeLog::update(const Batch& batch) {
  const AutoReset mode = batch.options().auto_reset;
  for (int i = 0; i < batch.num_envs(); ++i) {
    const auto at = static_cast<std::size_t>(i);
    if (finished_[at] != 0) {
      // This step began the next episode, or did nothing.
      if (mode == AutoReset::kNextStep) finished_[at] = 0;
      continue;
    }
    ++env_steps_;
    if ((batch.outputs().terminated[at] | batch.outputs().truncated[at]) == 0) continue;
    finish_episode(batch, i);
    finished_[at] = mode == AutoReset::kSameStep ? 0 : 1;
    if (mode == AutoReset::kOff) --moving_;
  }
}

void EpisodeLog::finish_episode(const Batch& batch, int index) {
  std::int32_t& quota = quota_[static_cast<std::size_t>(index)];
  if (quota == 0) return;
  --quota;
  const auto ended = [&batch](const char* name) {
    return batch.options().auto_reset == AutoReset::kSameStep ? batch.final_output(name)
                                                              : batch.output(name);
  };
  ++episodes_;
  if (value_of<std::uint8_t>(ended("success_once"), index) != 0) ++successes_;
  return_sum_ += value_of<double>(ended("episode_return"), index);
}

}  // namespace engram::apps
