#include "protocol/eval/probe/condition_player.h"

#include <algorithm>

#include "protocol/eval/policies/scripted_actor.h"
#include "protocol/eval/policies/seed_commitment.h"
#include "protocol/eval/probe/trial_player.h"

namespace engram {
namespace {

template <class Result, class Each>
void each_field(Result& result, Each&& each) {
  each(result.played);
  each(result.exchanged);
  each(result.success);
  each(result.answered);
  each(result.correct);
  each(result.compared);
  each(result.same_present);
  each(result.other_answered);
  each(result.answer);
  each(result.other_answer);
}

}  // namespace

// Dense rewards measure the way to what is hidden: presents would differ in them.
MakeOptions probe_environment(const Protocol& protocol, const ConstantTable& constants) {
  MakeOptions options = protocol.environment;
  options.constants = constants;
  options.reward_mode = RewardMode::kSparse;
  options.auto_reset = AutoReset::kOff;
  options.threads = 1;
  options.num_envs = 1;
  return options;
}

ConditionPlayer::ConditionPlayer(const std::vector<ProbeCondition>& conditions,
                                 const Protocol& protocol, int workers)
    : conditions_(conditions),
      protocol_(protocol),
      workspaces_(static_cast<std::size_t>(workers)) {}

void ConditionPlayer::play(const WorkItem& item, const WorkContext& context) {
  Workspace& workspace = workspaces_[static_cast<std::size_t>(context.worker())];
  try {
    play_item(item, context, workspace);
    if (context.stopped()) workspace.policy.reset();
  } catch (...) {
    workspace.policy.reset();  // ends its process on this thread
    throw;
  }
}

std::vector<TrialResult> ConditionPlayer::unpack(std::span<const std::byte> bytes) {
  ByteReader in(bytes);
  std::vector<TrialResult> group(in.get<std::uint32_t>());
  for (TrialResult& trial : group) {
    each_field(trial, [&in]<class T>(T& field) { field = in.get<T>(); });
  }
  return group;
}

void ConditionPlayer::play_item(const WorkItem& item, const WorkContext& context,
                                Workspace& workspace) const {
  const ProbeCondition& condition = conditions_[static_cast<std::size_t>(item.task)];
  prepare(workspace, item.task);
  if (protocol_.external && !condition.control && !workspace.policy) {
    workspace.policy = protocol_.external(context);
  }
  const ItemTrials all = trials_of(item, condition, *workspace.lookahead);
  Batch& batch = *workspace.batch;
  const auto actor = make_actor(batch, condition, workspace.policy.get(), context);
  std::unique_ptr<EpisodeActor> other_actor;
  PolicyBatch main{&batch, actor.get()};
  PolicyBatch other = main;
  if (workspace.other) {
    other_actor = make_actor(*workspace.other, condition, workspace.policy.get(), context);
    other = {workspace.other.get(), other_actor.get()};
  }
  const auto label = [&all](std::size_t trial) { return all.labels[trial]; };
  const auto take = [&](std::size_t group, std::span<const TrialResult> results) {
    if (workspace.policy) workspace.policy->check_no_pending_reply();
    ByteWriter out;
    out.put(static_cast<std::int32_t>(group));
    out.put(static_cast<std::uint32_t>(results.size()));
    for (const TrialResult& result : results) {
      each_field(result, [&out](const auto& field) { out.put(field); });
    }
    context.emit(out.take());
  };
  TrialPlayer(main, other, label).play(all.trials, all.sizes, context, take);
}

// Trials of one seed run side by side, so each has a number of its own, and no two conditions share
// one: a memory that goes by the number must not mix them.
ConditionPlayer::ItemTrials ConditionPlayer::trials_of(const WorkItem& item,
                                                       const ProbeCondition& condition,
                                                       Lookahead& lookahead) const {
  ItemTrials all;
  for (int i = 0; i < item.count; ++i) {
    const std::uint64_t seed = item.first_seed + static_cast<std::uint64_t>(i);
    const int first = static_cast<int>(all.trials.size());
    const TrialGroup group = condition.trials(lookahead, seed);
    all.sizes.push_back(static_cast<std::uint32_t>(group.size()));
    for (std::size_t place = 0; place < group.size(); ++place) {
      all.trials.push_back(group[place]);
      if (group[place].twin >= 0) all.trials.back().twin += first;
      const std::string name = std::string(condition.entry->id) + " " + condition.name + " trial " +
                               std::to_string(place);
      all.labels.push_back({static_cast<int>(seed - protocol_.start_seed),
                            opaque_number(protocol_.number_key, name, seed), seed});
    }
  }
  return all;
}

void ConditionPlayer::prepare(Workspace& workspace, int condition) const {
  if (workspace.condition == condition) return;
  const ProbeCondition& next = conditions_[static_cast<std::size_t>(condition)];
  workspace.condition = -1;
  workspace.batch.reset();
  workspace.other.reset();
  MakeOptions options = probe_environment(protocol_, next.constants);
  workspace.lookahead = std::make_unique<Lookahead>(next.entry->id, options);
  options.num_envs = std::min(protocol_.num_envs, protocol_.episodes);
  if (!next.control && !protocol_.external) options.policy_seed = protocol_.policy_seed;
  workspace.batch = make(next.entry->id, options);
  if (next.other != nullptr) {
    options.constants = protocol_.environment.constants;
    workspace.other = make(next.other->id, options);
  }
  workspace.condition = condition;
}

std::unique_ptr<EpisodeActor> ConditionPlayer::make_actor(Batch& batch,
                                                          const ProbeCondition& condition,
                                                          ExternalPolicy* policy,
                                                          const WorkContext& context) const {
  if (condition.control || policy == nullptr) {
    return std::make_unique<ScriptedActor>(batch, condition.control.value_or(protocol_.policy),
                                           protocol_.latency);
  }
  const ChunkedPolicyOptions options{protocol_.tell_episodes, protocol_.policy_seed,
                                     protocol_.latency};
  return std::make_unique<ChunkedPolicy>(batch, *policy, context, options);
}

}  // namespace engram
