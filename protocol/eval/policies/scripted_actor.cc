#include "protocol/eval/policies/scripted_actor.h"

#include <algorithm>

namespace engram {

ScriptedActor::ScriptedActor(Batch& batch, Policy policy, int latency)
    : batch_(batch),
      policy_(batch, policy),
      latency_(latency),
      states_(static_cast<std::size_t>(batch.num_envs())) {}

void ScriptedActor::start(int env, const EpisodeLabel& /*label*/) {
  states_[static_cast<std::size_t>(env)] = {true, ActionQueue(latency_), {}};
}

void ScriptedActor::replace_scene(int env, const EpisodeLabel& /*label*/) {
  EpisodeState& state = states_[static_cast<std::size_t>(env)];
  state.busy = true;
  state.queue = ActionQueue(latency_);
}

void ScriptedActor::finish(int env) { states_[static_cast<std::size_t>(env)].busy = false; }

// Scripts follow every step, also those between a question and its answer: what they remember must
// not depend on the other environments' questions.
void ScriptedActor::act(std::span<float> actions, std::span<std::uint8_t> commanded) {
  policy_.act(actions);
  const auto dim = static_cast<std::size_t>(batch_.action_dim());
  for (std::size_t i = 0; i < states_.size(); ++i) {
    EpisodeState& state = states_[i];
    const std::span<float> action = actions.subspan(i * dim, dim);
    commanded[i] = 1;
    if (!state.busy) continue;
    if (state.queue.empty()) {
      const PolicyView view = view_of(batch_, static_cast<int>(i));
      state.digests.add_question(view);
      state.digests.add_answer(view.step, action, batch_.action_dim());
      state.queue.answer(action);
    }
    commanded[i] = state.queue.next(action) ? 1 : 0;
  }
}

const EpisodeDigests& ScriptedActor::digests(int env) const {
  return states_[static_cast<std::size_t>(env)].digests;
}

}  // namespace engram
