#include "protocol/probe/condition_player.h"

#include <algorithm>

#include "protocol/evaluation/scripted_actor.h"
#include "protocol/probe/trial_player.h"

namespace engram {
namespace {

template <class Result, class Each>
void each_field(Result& result, Each&& each) {
  each(result.played);
  each(result.success);
  each(result.answered);
  each(result.correct);
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

Bytes ConditionPlayer::play(const WorkItem& item, const WorkContext& context) {
  Workspace& workspace = workspaces_[static_cast<std::size_t>(context.worker())];
  try {
    Bytes result = play_item(item, context, workspace);
    if (context.stopped()) workspace.policy.reset();
    return result;
  } catch (...) {
    workspace.policy.reset();  // ends its process on this thread
    throw;
  }
}

ConditionResults ConditionPlayer::unpack(std::span<const std::byte> bytes, int count) {
  ByteReader in(bytes);
  ConditionResults results(static_cast<std::size_t>(count));
  for (std::vector<TrialResult>& group : results) {
    group.resize(in.get<std::uint32_t>());
    for (TrialResult& trial : group) {
      each_field(trial, [&in]<class T>(T& field) { field = in.get<T>(); });
    }
  }
  return results;
}

Bytes ConditionPlayer::play_item(const WorkItem& item, const WorkContext& context,
                                 Workspace& workspace) const {
  const ProbeCondition& condition = conditions_[static_cast<std::size_t>(item.task)];
  prepare(workspace, item.task);
  if (protocol_.external && !condition.control && !workspace.policy) {
    workspace.policy = protocol_.external(context);
  }
  std::vector<Trial> trials;
  std::vector<std::uint64_t> seeds;
  std::vector<std::uint32_t> sizes;
  for (int i = 0; i < item.count; ++i) {
    const std::uint64_t seed = item.first_seed + static_cast<std::uint64_t>(i);
    const int first = static_cast<int>(trials.size());
    const TrialGroup group = condition.trials(*workspace.lookahead, seed);
    sizes.push_back(static_cast<std::uint32_t>(group.size()));
    for (const Trial& trial : group) {
      trials.push_back(trial);
      if (trial.twin >= 0) trials.back().twin += first;
      seeds.push_back(seed);
    }
  }
  Batch& env = *workspace.env;
  const auto actor = make_actor(env, condition, workspace.policy.get(), context);
  std::unique_ptr<EpisodeActor> other_actor;
  ProbeStage main{&env, actor.get()};
  ProbeStage other = main;
  if (workspace.other) {
    other_actor = make_actor(*workspace.other, condition, workspace.policy.get(), context);
    other = {workspace.other.get(), other_actor.get()};
  }
  const auto label = [&](std::size_t trial) {
    return label_episode(static_cast<int>(seeds[trial] - protocol_.start_seed), condition.entry->id,
                         seeds[trial], protocol_.number_key, protocol_.tell_episodes);
  };
  const std::vector<TrialResult> results = TrialPlayer(main, other, label).play(trials, context);
  if (context.stopped()) return {};
  if (workspace.policy) workspace.policy->require_drained();
  ByteWriter out;
  auto next = results.begin();
  for (const std::uint32_t size : sizes) {
    out.put(size);
    for (std::uint32_t i = 0; i < size; ++i) {
      each_field(*next++, [&out](const auto& field) { out.put(field); });
    }
  }
  return out.take();
}

void ConditionPlayer::prepare(Workspace& workspace, int condition) const {
  if (workspace.condition == condition) return;
  const ProbeCondition& next = conditions_[static_cast<std::size_t>(condition)];
  workspace.condition = -1;
  workspace.env.reset();
  workspace.other.reset();
  MakeOptions options = probe_environment(protocol_, next.constants);
  workspace.lookahead = std::make_unique<Lookahead>(next.entry->id, options);
  options.num_envs = std::min(protocol_.num_envs, protocol_.episodes);
  if (!next.control && !protocol_.external) options.policy_seed = protocol_.policy_seed;
  workspace.env = make(next.entry->id, options);
  if (next.other != nullptr) {
    options.constants = protocol_.environment.constants;
    workspace.other = make(next.other->id, options);
  }
  workspace.condition = condition;
}

std::unique_ptr<EpisodeActor> ConditionPlayer::make_actor(Batch& env,
                                                          const ProbeCondition& condition,
                                                          ExternalPolicy* policy,
                                                          const WorkContext& context) const {
  if (condition.control || policy == nullptr) {
    return std::make_unique<ScriptedActor>(env, condition.control.value_or(protocol_.policy),
                                           protocol_.latency);
  }
  const ChunkedPolicyOptions options{protocol_.tell_episodes, protocol_.policy_seed,
                                     protocol_.latency};
  return std::make_unique<ChunkedPolicy>(env, *policy, context, options);
}

}  // namespace engram
