#include "protocol/eval/policies/scripted_actor.h"

#include <algorithm>

namespace engram {

ScriptedActor::ScriptedActor(Batch& env, Policy policy, int latency)
    : env_(env),
      policy_(env, policy),
      latency_(latency),
      slots_(static_cast<std::size_t>(env.num_envs())) {}

void ScriptedActor::start(int slot, const EpisodeLabel& /*label*/) {
  slots_[static_cast<std::size_t>(slot)] = {true, ActionQueue(latency_), {}};
}

void ScriptedActor::go_on(int slot, const EpisodeLabel& /*label*/) {
  Slot& own = slots_[static_cast<std::size_t>(slot)];
  own.busy = true;
  own.queue = ActionQueue(latency_);
}

void ScriptedActor::finish(int slot) { slots_[static_cast<std::size_t>(slot)].busy = false; }

// Scripts follow every step, also those between a question and its answer: what they remember must
// not depend on the other environments' questions.
void ScriptedActor::act(std::span<float> actions, std::span<std::uint8_t> commanded) {
  policy_.act(actions);
  const auto dim = static_cast<std::size_t>(env_.action_dim());
  for (std::size_t i = 0; i < slots_.size(); ++i) {
    Slot& slot = slots_[i];
    const std::span<float> action = actions.subspan(i * dim, dim);
    commanded[i] = 1;
    if (!slot.busy) continue;
    if (slot.queue.empty()) {
      const PolicyView view = view_of(env_, static_cast<int>(i));
      slot.digests.add_question(view);
      slot.digests.add_answer(view.step, action, env_.action_dim());
      slot.queue.answer(action);
    }
    commanded[i] = slot.queue.next(action) ? 1 : 0;
  }
}

const EpisodeDigests& ScriptedActor::digests(int slot) const {
  return slots_[static_cast<std::size_t>(slot)].digests;
}

}  // namespace engram
