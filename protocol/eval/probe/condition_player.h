// Plays blocks of a condition's episode numbers on worker threads.
#pragma once

#include <memory>
#include <vector>

#include "protocol/eval/policies/episode_actor.h"
#include "protocol/eval/probe/probe_plan.h"
#include "protocol/eval/run/evaluate.h"

namespace engram {

class ConditionPlayer {
 public:
  // Both outlive this object. Numbers of items' tasks are places among the conditions.
  ConditionPlayer(const std::vector<ProbeCondition>& conditions, const Protocol& protocol,
                  int workers);

  // Work of a WorkFunction, which emits the results of each episode number: its place in the item,
  // and what `unpack` reads.
  void play(const WorkItem& item, const WorkContext& context);
  static std::vector<TrialResult> unpack(std::span<const std::byte> bytes);

 private:
  // A thread's batches, kept while the condition stays the same.
  struct Workspace {
    int condition = -1;
    std::unique_ptr<Batch> batch;
    std::unique_ptr<Batch> other;
    std::unique_ptr<Lookahead> lookahead;
    std::unique_ptr<ExternalPolicy> policy;
  };

  // The trials of an item's episode numbers.
  struct ItemTrials {
    std::vector<Trial> trials;
    std::vector<EpisodeLabel> labels;  // of each trial
    std::vector<std::uint32_t> sizes;  // trials of each episode number
  };

  ItemTrials trials_of(const WorkItem& item, const ProbeCondition& condition,
                       Lookahead& lookahead) const;
  void play_item(const WorkItem& item, const WorkContext& context, Workspace& workspace) const;
  void prepare(Workspace& workspace, int condition) const;
  std::unique_ptr<EpisodeActor> make_actor(Batch& batch, const ProbeCondition& condition,
                                           ExternalPolicy* policy,
                                           const WorkContext& context) const;

  const std::vector<ProbeCondition>& conditions_;
  const Protocol& protocol_;
  std::vector<Workspace> workspaces_;
};

// Options of a batch for probes.
MakeOptions probe_environment(const Protocol& protocol, const ConstantTable& constants);

}  // namespace engram
