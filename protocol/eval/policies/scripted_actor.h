// One of engram's own policies in an evaluation.
#pragma once

#include <vector>

#include "core/batch/scripted_policy.h"
#include "protocol/eval/policies/action_queue.h"
#include "protocol/eval/policies/episode_actor.h"

namespace engram {

class ScriptedActor final : public EpisodeActor {
 public:
  // latency: control steps from a question to its answer.
  ScriptedActor(Batch& env, Policy policy, int latency);

  void start(int slot, const EpisodeLabel& label) override;
  void go_on(int slot, const EpisodeLabel& label) override;
  void finish(int slot) override;
  void act(std::span<float> actions, std::span<std::uint8_t> commanded) override;
  const EpisodeDigests& digests(int slot) const override;

 private:
  struct Slot {
    bool busy = false;
    ActionQueue queue;
    EpisodeDigests digests;
  };

  const Batch& env_;
  ScriptedPolicy policy_;
  int latency_;
  std::vector<Slot> slots_;
};

}  // namespace engram
