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
  ScriptedActor(Batch& batch, Policy policy, int latency);

  void start(int env, const EpisodeLabel& label) override;
  void replace_scene(int env, const EpisodeLabel& label) override;
  void finish(int env) override;
  void act(std::span<float> actions, std::span<std::uint8_t> commanded) override;
  const EpisodeDigests& digests(int env) const override;

 private:
  struct EpisodeState {
    bool busy = false;
    ActionQueue queue;
    EpisodeDigests digests;
  };

  const Batch& batch_;
  ScriptedPolicy policy_;
  int latency_;
  std::vector<EpisodeState> states_;
};

}  // namespace engram
