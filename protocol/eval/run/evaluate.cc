#include "protocol/eval/run/evaluate.h"

#include <algorithm>
#include <chrono>
#include <map>
#include <numeric>
#include <string>
#include <type_traits>

#include "core/batch/queries.h"
#include "protocol/eval/policies/choosing_policy.h"
#include "protocol/eval/policies/scripted_actor.h"
#include "protocol/eval/run/mean.h"
#include "protocol/eval/run/sample_images.h"
#include "protocol/make/episodes.h"
#include "protocol/make/rows.h"

namespace engram {
namespace {

// --- workers: the episodes of one item ---

struct EpisodeResult {
  std::uint8_t success = 0;
  double episode_return = 0;
  std::int32_t length = 0;
  Answer answer;
  Completion completion;
  EpisodeDigests digests;
};
static_assert(std::is_trivially_copyable_v<EpisodeResult>, "messages hold it as it lies in memory");

struct ItemResult {
  double chance = 1;
  double answer_chance = 1;
  std::uint8_t has_answers = 0;   // for answers
  std::uint8_t has_subtasks = 0;  // there are subtasks
  std::vector<EpisodeResult> episodes;
  std::int32_t chunk_size = 1;
  std::uint64_t unstable = 0;
  double seconds = 0;
  Bytes sample;

  Bytes pack() const {
    ByteWriter out;
    out.put(chance);
    out.put(answer_chance);
    out.put(has_answers);
    out.put(has_subtasks);
    out.append(std::span<const EpisodeResult>(episodes));
    out.put(chunk_size);
    out.put(unstable);
    out.put(seconds);
    out.append(std::span<const std::byte>(sample));
    return out.take();
  }

  static ItemResult unpack(std::span<const std::byte> bytes, int count) {
    ByteReader in(bytes);
    ItemResult result;
    result.chance = in.get<double>();
    result.answer_chance = in.get<double>();
    result.has_answers = in.get<std::uint8_t>();
    result.has_subtasks = in.get<std::uint8_t>();
    result.episodes = in.values<EpisodeResult>(static_cast<std::size_t>(count));
    result.chunk_size = in.get<std::int32_t>();
    result.unstable = in.get<std::uint64_t>();
    result.seconds = in.get<double>();
    result.sample.assign(in.rest().begin(), in.rest().end());
    return result;
  }
};

// Records the results of an item's episodes, and images of the task's first one.
class EpisodeObserver {
 public:
  EpisodeObserver(Batch& batch, ItemResult& result, EpisodeActor& actor, const WorkItem& item,
                  const Protocol& protocol)
      : batch_(batch),
        result_(result),
        actor_(actor),
        item_(item),
        protocol_(protocol),
        done_(static_cast<std::size_t>(batch.num_envs())),
        samples_(protocol.samples && item.repeat == 0 && item.first_seed == protocol.start_seed) {}

  void start(int env, int episode) {
    actor_.start(env, label_of(episode));
    if (samples_ && episode == 0) sample_slot_ = env;
    if (env == sample_slot_) images_.sample(batch_, env);
    annotator_ = Queries(batch_).annotator();
    done_[static_cast<std::size_t>(env)] = 0;
    note_subtasks(env);
  }
  void before_step(int /*env*/, std::span<float> /*action*/) {}
  void after_step(int env) {
    if (env == sample_slot_) images_.sample(batch_, env);
    note_subtasks(env);
  }
  void finish(int env, int episode) {
    EpisodeResult& result = result_.episodes.at(static_cast<std::size_t>(episode));
    result.success = value_of<std::uint8_t>(batch_.output("success_once"), env);
    result.episode_return = value_of<double>(batch_.output("episode_return"), env);
    result.length = value_of<std::int32_t>(batch_.output("elapsed_steps"), env);
    if (result_.has_answers != 0) {
      result.answer = {
          .given = value_of<std::uint8_t>(batch_.output("answered"), env),
          .first = value_of<std::int32_t>(batch_.output("first_answer"), env),
          .correct = value_of<std::uint8_t>(batch_.output("first_answer_correct"), env)};
    }
    if (annotator_ != nullptr) result.completion = completion_of(env, result.success != 0);
    result.digests = actor_.digests(env);
    actor_.finish(env);
    if (env == sample_slot_) {
      result_.sample = images_.png();
      sample_slot_ = -1;
    }
  }

 private:
  void note_subtasks(int env) {
    if (annotator_ == nullptr) return;
    int& most = done_[static_cast<std::size_t>(env)];
    most = std::max(most, annotator_->subtasks_done(env));
  }

  Completion completion_of(int env, bool success) const {
    const auto subtasks = static_cast<std::int32_t>(annotator_->plan(env).size());
    const std::int32_t done = done_[static_cast<std::size_t>(env)];
    return {success ? subtasks : std::min(done, subtasks - 1), subtasks};
  }

  EpisodeLabel label_of(int episode) const {
    const std::uint64_t seed = item_.first_seed + static_cast<std::uint64_t>(episode);
    return label_episode(static_cast<int>(seed - protocol_.start_seed), batch_.info().id, seed,
                         protocol_.number_key, protocol_.tell_episodes);
  }

  Batch& batch_;
  ItemResult& result_;
  EpisodeActor& actor_;
  const WorkItem& item_;
  const Protocol& protocol_;
  const Annotator* annotator_ = nullptr;  // null: no subtasks
  std::vector<int> done_;                 // by each slot's episode, at most
  bool samples_;
  int sample_slot_ = -1;
  SampleImages images_;
};

class ItemEvaluator {
 public:
  ItemEvaluator(const Protocol& protocol, int workers)
      : protocol_(protocol), workspaces_(static_cast<std::size_t>(workers)) {}

  // Ends the processes of policies on the worker threads, in parallel.
  Bytes evaluate(const WorkItem& item, const WorkContext& context) {
    auto& policy = workspaces_[static_cast<std::size_t>(context.worker())].policy;
    try {
      Bytes result = evaluate_item(item, context);
      if (context.stopped()) policy.reset();
      return result;
    } catch (...) {
      policy.reset();
      throw;
    }
  }

 private:
  Bytes evaluate_item(const WorkItem& item, const WorkContext& context) {
    const auto start = std::chrono::steady_clock::now();
    Workspace& workspace = workspaces_[static_cast<std::size_t>(context.worker())];
    if (protocol_.external && !workspace.policy) workspace.policy = protocol_.external(context);
    const RegistryEntry& entry = entry_at(item.task);
    const std::uint64_t policy_seed =
        protocol_.policy_seed + static_cast<std::uint64_t>(item.repeat);
    MakeOptions environment = protocol_.environment;
    if (!protocol_.external) environment.policy_seed = policy_seed;
    Batch& batch = workspace.batch.of(entry.id, item.count, protocol_.num_envs, environment);

    ItemResult result;
    result.chance = chance_in(batch);
    result.answer_chance = batch.info().answer_chance();
    result.has_answers = batch.info().answer.empty() ? 0 : 1;
    result.episodes.resize(static_cast<std::size_t>(item.count));
    const Queries queries(batch);
    const std::uint64_t unstable = queries.unstable_count();
    const std::unique_ptr<EpisodeActor> actor =
        make_actor(batch, workspace.policy.get(), policy_seed, context);
    EpisodeObserver observer(batch, result, *actor, item, protocol_);
    const auto act = [&actor](std::span<float> actions, std::span<std::uint8_t> commanded) {
      actor->act(actions, commanded);
    };
    if (!play_episodes(batch, item.first_seed, item.count, context, act, observer)) {
      workspace.batch.clear();
      return {};
    }
    result.has_subtasks = queries.annotator() != nullptr ? 1 : 0;
    result.chunk_size = actor->longest_chunk();
    if (workspace.policy) workspace.policy->check_no_pending_reply();
    result.unstable = queries.unstable_count() - unstable;
    result.seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    return result.pack();
  }

  // Success rate of guessing, in actions or among the choices.
  double chance_in(const Batch& batch) const {
    const TaskInfo& info = batch.info();
    if (!protocol_.choices) return info.chance();
    const Queries queries(batch);
    for (std::size_t i = 0; i < info.options.size(); ++i) {
      const bool strict = info.options[i].name == kStrictOption && queries.option_values()[i] != 0;
      if (strict) return info.answer_chance();  // a wrong choice fails
    }
    const double of_choices = queries.choices()->choice_chance();
    return of_choices > 0 ? of_choices : info.chance();
  }

  // external: the policy, or null for engram's own.
  std::unique_ptr<EpisodeActor> make_actor(Batch& batch, ExternalPolicy* external,
                                           std::uint64_t policy_seed,
                                           const WorkContext& context) const {
    if (external == nullptr) {
      return std::make_unique<ScriptedActor>(batch, protocol_.policy, protocol_.latency);
    }
    return make_external_actor(batch, *external, context,
                               {protocol_.tell_episodes, policy_seed, protocol_.latency},
                               protocol_.choices ? protocol_.choices_stride : 0);
  }

  // Working memory of one thread.
  struct Workspace {
    EpisodeBatch batch;
    std::unique_ptr<ExternalPolicy> policy;
  };

  const Protocol& protocol_;
  std::vector<Workspace> workspaces_;
};

// --- rank 0 ---

class Evaluation final : public WorkSource {
 public:
  Evaluation(const std::vector<const RegistryEntry*>& tasks, const Protocol& protocol,
             const EvaluationListener& listener, int block)
      : protocol_(protocol), listener_(listener), block_(block), order_(tasks) {
    // Long episodes first, so that the last items are short and all cores are busy to the end.
    std::stable_sort(
        order_.begin(), order_.end(),
        [](const RegistryEntry* a, const RegistryEntry* b) { return a->horizon > b->horizon; });
  }

  std::optional<WorkItem> next() override {
    if (task_ == order_.size()) return std::nullopt;
    const RegistryEntry* entry = order_[task_];
    const int row = entry->index;
    if (episode_ == 0 && repeat_ == 0) results_[row] = empty_result(entry);
    const WorkItem item{row, protocol_.start_seed + static_cast<std::uint64_t>(episode_),
                        std::min(block_, protocol_.episodes - episode_), repeat_};
    episode_ += item.count;
    if (episode_ < protocol_.episodes) return item;
    episode_ = 0;
    if (++repeat_ < protocol_.repeat) return item;
    repeat_ = 0;
    ++task_;
    return item;
  }

  void accept(const WorkItem& item, Bytes bytes) override {
    const ItemResult part = ItemResult::unpack(bytes, item.count);
    const auto found = results_.find(item.task);
    TaskResult& result = found->second.result;
    auto i = static_cast<std::size_t>(item.first_seed - protocol_.start_seed) +
             static_cast<std::size_t>(item.repeat) * static_cast<std::size_t>(protocol_.episodes);
    if (part.has_answers != 0) result.answers.resize(result.successes.size());
    if (part.has_subtasks != 0) result.completions.resize(result.successes.size());
    for (const EpisodeResult& episode : part.episodes) {
      result.successes[i] = episode.success != 0;
      result.returns[i] = episode.episode_return;
      result.lengths[i] = episode.length;
      result.digests[i] = episode.digests;
      if (part.has_answers != 0) result.answers[i] = episode.answer;
      if (part.has_subtasks != 0) result.completions[i] = episode.completion;
      ++i;
    }
    result.chance = part.chance;
    result.answer_chance = part.answer_chance;
    result.chunk_size = std::max(result.chunk_size, static_cast<int>(part.chunk_size));
    result.unstable += part.unstable;
    result.thread_seconds += part.seconds;
    if (!part.sample.empty()) result.sample = part.sample;
    found->second.episodes += item.count;
    status_.episodes += item.count;
    if (found->second.episodes < protocol_.all_episodes()) return;
    ++status_.tasks;
    TaskResult whole = std::move(result);
    results_.erase(found);
    listener_.finished(std::move(whole));
  }

  void tick(const WorkStatus& work) override {
    if (!listener_.tick) return;
    status_.env_steps = work.env_steps;
    status_.running.clear();
    for (const auto& [row, partial] : results_) {
      status_.running.push_back({partial.result.entry, partial.episodes});
    }
    listener_.tick(status_);
  }

 private:
  struct Partial {
    TaskResult result;
    int episodes = 0;  // finished
  };

  Partial empty_result(const RegistryEntry* entry) const {
    Partial partial;
    const auto count = static_cast<std::size_t>(protocol_.all_episodes());
    partial.result.entry = entry;
    partial.result.successes.resize(count);
    partial.result.returns.resize(count);
    partial.result.lengths.resize(count);
    partial.result.digests.resize(count);
    for (int i = 0; i < protocol_.all_episodes(); ++i) {
      partial.result.seeds.push_back(protocol_.start_seed +
                                     static_cast<std::uint64_t>(i % protocol_.episodes));
    }
    return partial;
  }

  const Protocol& protocol_;
  const EvaluationListener& listener_;
  int block_;  // episodes of an item
  std::vector<const RegistryEntry*> order_;
  std::size_t task_ = 0;  // the next item: task in `order_`, round, first episode
  int repeat_ = 0;
  int episode_ = 0;
  std::map<int, Partial> results_;  // of tasks in progress
  EvaluationStatus status_;
};

}  // namespace

double TaskResult::success_rate() const { return mean(successes); }
double TaskResult::answer_rate() const {
  std::vector<bool> correct;
  for (const Answer& answer : answers) correct.push_back(answer.correct != 0);
  return mean(correct);
}
double TaskResult::completion_rate() const {
  std::vector<double> shares;
  for (const Completion& completion : completions) shares.push_back(completion.share());
  return mean(shares);
}
double TaskResult::mean_return() const { return mean(returns); }
double TaskResult::mean_length() const { return mean(lengths); }
std::int64_t TaskResult::env_steps() const {
  return std::accumulate(lengths.begin(), lengths.end(), std::int64_t{0});
}

void evaluate(Ranks& ranks, const std::vector<const RegistryEntry*>& tasks,
              const Protocol& protocol, const EvaluationListener& listener) {
  ItemEvaluator evaluator(protocol, worker_threads(protocol.threads, ranks));
  Evaluation evaluation(tasks, protocol, listener, std::min(protocol.num_envs, protocol.episodes));
  distribute_work(
      ranks, protocol.threads,
      [&evaluator](const WorkItem& item, const WorkContext& context) {
        return evaluator.evaluate(item, context);
      },
      evaluation);
}

}  // namespace engram
