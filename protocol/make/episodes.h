// Plays the episodes of consecutive seeds in a batch of environments.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <string_view>
#include <type_traits>
#include <vector>

#include "protocol/make/make.h"
#include "protocol/parallel/work_item.h"

namespace engram {

// Plays `count` episodes with seeds first_seed, first_seed + 1, ..., as many at a time as the batch
// has environments: one whose episode has ended takes the next seed, or stands still if there is
// none. The batch must have AutoReset::kOff and, if it has never been reset, no more environments
// than `count`. Returns false if the context was stopped before the last episode had ended; then
// the batch cannot be used any more.
//
// act(actions) or act(actions, commanded) writes the actions of all environments; those of ended
// ones are ignored. A 0 in `commanded` is for those that go without a new command. The watcher is
// called
//
// - start(slot, i): when environment `slot` shows the first observation of episode i < count
// - before_step(slot, action): for every environment under way; it may change the action
// - after_step(slot): for the same ones, when the step is done
// - finish(slot, i): when episode i has ended
template <class Act, class Watcher>
bool play_episodes(Batch& batch, std::uint64_t first_seed, int count, const WorkContext& context,
                   Act&& act, Watcher&& watcher) {
  const int envs = batch.num_envs();
  const auto dim = static_cast<std::size_t>(batch.action_dim());
  std::vector<float> actions(static_cast<std::size_t>(envs) * dim);
  std::vector<int> episode(static_cast<std::size_t>(envs), -1);  // -1: none
  std::vector<std::uint8_t> commanded(episode.size(), 1);
  std::vector<std::uint8_t> mask(episode.size());
  std::vector<std::uint64_t> seeds(episode.size());
  int started = 0;
  int finished = 0;
  const auto start_waiting = [&] {
    if (started == count) return;
    std::fill(mask.begin(), mask.end(), std::uint8_t{0});
    for (std::size_t env = 0; env < episode.size() && started < count; ++env) {
      if (episode[env] >= 0) continue;
      mask[env] = 1;
      seeds[env] = first_seed + static_cast<std::uint64_t>(started);
      episode[env] = started++;
    }
    batch.reset({.mask = mask, .seeds = seeds, .pins = nullptr});
    for (int env = 0; env < envs; ++env) {
      const auto i = static_cast<std::size_t>(env);
      if (mask[i] != 0) watcher.start(env, episode[i]);
    }
  };
  start_waiting();
  while (finished < count && !context.stopped()) {
    if constexpr (std::is_invocable_v<Act&, std::span<float>>) {
      act(std::span<float>(actions));
    } else {
      act(std::span<float>(actions), std::span<std::uint8_t>(commanded));
    }
    for (int env = 0; env < envs; ++env) {
      const auto i = static_cast<std::size_t>(env);
      if (episode[i] >= 0) watcher.before_step(env, std::span(actions).subspan(i * dim, dim));
    }
    batch.step(actions, commanded);
    context.count_env_steps(static_cast<std::uint64_t>(started - finished));
    bool vacancy = false;
    for (int env = 0; env < envs; ++env) {
      const auto i = static_cast<std::size_t>(env);
      if (episode[i] < 0) continue;
      watcher.after_step(env);
      if ((batch.outputs().terminated[i] | batch.outputs().truncated[i]) == 0) continue;
      watcher.finish(env, episode[i]);
      episode[i] = -1;
      ++finished;
      vacancy = true;
    }
    if (vacancy) start_waiting();
  }
  return finished == count;
}

// The batch of one worker thread, kept from item to item while task and policy seed stay the same.
class EpisodeBatch {
 public:
  // A single-threaded batch that can play `count` episodes, with at most `num_envs` at a time.
  // options: of every batch; auto_reset, threads and num_envs are set here.
  Batch& of(std::string_view id, int count, int num_envs, const MakeOptions& options);
  void clear() { batch_.reset(); }

 private:
  std::string id_;
  std::uint64_t policy_seed_ = 0;
  std::unique_ptr<Batch> batch_;
};

}  // namespace engram
