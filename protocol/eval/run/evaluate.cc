#include "protocol/eval/run/evaluate.h"

#include <algorithm>
#include <chrono>
#include <map>
#include <numeric>
#include <string>
#include <type_traits>
#include <utility>

#include "core/batch/queries.h"
#include "protocol/eval/policies/choosing_policy.h"
#include "protocol/eval/policies/scripted_actor.h"
#include "protocol/eval/run/mean.h"
#include "protocol/eval/run/sample_images.h"
#include "protocol/make/episodes.h"
#include "protocol/make/rows.h"
#include "protocol/parallel/episode_queue.h"

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

// What is known of a finished episode, and of its task from it.
struct EpisodeRecord {
  double chance = 1;
  double answer_chance = 1;
  std::uint8_t has_answers = 0;   // for answers
  std::uint8_t has_subtasks = 0;  // there are subtasks
  EpisodeResult result;
  std::int32_t chunk_size = 1;  // the longest so far
  // Since the last episode of the item:
  std::uint64_t unstable = 0;
  double seconds = 0;
  Bytes sample;

  Bytes pack() const {
    ByteWriter out;
    out.put(chance);
    out.put(answer_chance);
    out.put(has_answers);
    out.put(has_subtasks);
    out.append(std::span<const EpisodeResult>(&result, 1));
    out.put(chunk_size);
    out.put(unstable);
    out.put(seconds);
    out.append(std::span<const std::byte>(sample));
    return out.take();
  }

  static EpisodeRecord unpack(std::span<const std::byte> bytes) {
    ByteReader in(bytes);
    EpisodeRecord record;
    record.chance = in.get<double>();
    record.answer_chance = in.get<double>();
    record.has_answers = in.get<std::uint8_t>();
    record.has_subtasks = in.get<std::uint8_t>();
    record.result = in.values<EpisodeResult>(1).front();
    record.chunk_size = in.get<std::int32_t>();
    record.unstable = in.get<std::uint64_t>();
    record.seconds = in.get<double>();
    record.sample.assign(in.rest().begin(), in.rest().end());
    return record;
  }
};

// Emits the results of an item's episodes, and images of the task's first one: the number of the
// episode in the item, and its record.
class EpisodeObserver {
 public:
  // task: what records have of the task.
  EpisodeObserver(Batch& batch, EpisodeRecord task, EpisodeActor& actor, const WorkItem& item,
                  const Protocol& protocol, const WorkContext& context, ExternalPolicy* policy)
      : batch_(batch),
        record_(std::move(task)),
        actor_(actor),
        item_(item),
        protocol_(protocol),
        context_(context),
        policy_(policy),
        unstable_(Queries(batch).unstable_count()),
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
    EpisodeResult& result = record_.result;
    result = {};
    result.success = value_of<std::uint8_t>(batch_.output("success_once"), env);
    result.episode_return = value_of<double>(batch_.output("episode_return"), env);
    result.length = value_of<std::int32_t>(batch_.output("elapsed_steps"), env);
    if (record_.has_answers != 0) {
      result.answer = {
          .given = value_of<std::uint8_t>(batch_.output("answered"), env),
          .first = value_of<std::int32_t>(batch_.output("first_answer"), env),
          .correct = value_of<std::uint8_t>(batch_.output("first_answer_correct"), env)};
    }
    record_.has_subtasks = annotator_ != nullptr ? 1 : 0;
    if (annotator_ != nullptr) result.completion = completion_of(env, result.success != 0);
    result.digests = actor_.digests(env);
    actor_.finish(env);
    record_.sample.clear();
    if (env == sample_slot_) {
      record_.sample = images_.png();
      sample_slot_ = -1;
    }
    emit(episode);
  }

 private:
  void emit(int episode) {
    if (policy_ != nullptr) policy_->check_no_pending_reply();
    const auto now = std::chrono::steady_clock::now();
    record_.seconds = std::chrono::duration<double>(now - std::exchange(since_, now)).count();
    const std::uint64_t unstable = Queries(batch_).unstable_count();
    record_.unstable = unstable - std::exchange(unstable_, unstable);
    record_.chunk_size = actor_.longest_chunk();
    ByteWriter out;
    out.put(static_cast<std::int32_t>(episode));
    const Bytes record = record_.pack();
    out.append(std::span<const std::byte>(record));
    context_.emit(out.take());
  }

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
  EpisodeRecord record_;  // of the last episode
  EpisodeActor& actor_;
  const WorkItem& item_;
  const Protocol& protocol_;
  const WorkContext& context_;
  ExternalPolicy* policy_;  // or null
  std::uint64_t unstable_;
  std::chrono::steady_clock::time_point since_ = std::chrono::steady_clock::now();
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
  void evaluate(const WorkItem& item, const WorkContext& context) {
    auto& policy = workspaces_[static_cast<std::size_t>(context.worker())].policy;
    try {
      evaluate_item(item, context);
      if (context.stopped()) policy.reset();
    } catch (...) {
      policy.reset();
      throw;
    }
  }

 private:
  void evaluate_item(const WorkItem& item, const WorkContext& context) {
    Workspace& workspace = workspaces_[static_cast<std::size_t>(context.worker())];
    if (protocol_.external && !workspace.policy) workspace.policy = protocol_.external(context);
    const RegistryEntry& entry = entry_at(item.task);
    const std::uint64_t policy_seed =
        protocol_.policy_seed + static_cast<std::uint64_t>(item.repeat);
    MakeOptions environment = protocol_.environment;
    if (!protocol_.external) environment.policy_seed = policy_seed;
    Batch& batch = workspace.batch.of(entry.id, item.count, protocol_.num_envs, environment);

    EpisodeRecord task;
    task.chance = chance_in(batch);
    task.answer_chance = batch.info().answer_chance();
    task.has_answers = batch.info().answer.empty() ? 0 : 1;
    const std::unique_ptr<EpisodeActor> actor =
        make_actor(batch, workspace.policy.get(), policy_seed, context);
    EpisodeObserver observer(batch, std::move(task), *actor, item, protocol_, context,
                             workspace.policy.get());
    const auto act = [&actor](std::span<float> actions, std::span<std::uint8_t> commanded) {
      actor->act(actions, commanded);
    };
    if (!play_episodes(batch, item.first_seed, item.count, context, act, observer)) {
      workspace.batch.clear();
    }
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
             const EvaluationListener& listener, const EpisodeStore& store)
      : protocol_(protocol),
        listener_(listener),
        journal_(store.journal),
        queue_(std::min(protocol.num_envs, protocol.episodes), protocol.episodes) {
    const std::vector<EpisodeRange> share = share_of(loads_of(tasks, protocol), store.shard);
    std::vector<std::size_t> order(tasks.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    // Long episodes first, so that the last items are short and all cores are busy to the end.
    std::ranges::stable_sort(
        order, [&](std::size_t a, std::size_t b) { return tasks[a]->horizon > tasks[b]->horizon; });
    for (const std::size_t i : order) {
      queue_.add(tasks[i]->index, share[i]);
      status_.wanted += share[i].size();
    }
    if (journal_ != nullptr) take_known(tasks);
  }

  std::optional<WorkItem> next() override {
    const std::optional<EpisodeQueue::Block> block = queue_.next();
    if (!block) return std::nullopt;
    (void)partial_of(block->task);
    return WorkItem{
        block->task,
        protocol_.start_seed + static_cast<std::uint64_t>(block->first % protocol_.episodes),
        block->count, block->first / protocol_.episodes};
  }

  void accept(const WorkItem& item, Bytes bytes) override {
    ByteReader in(bytes);
    const int episode = item.repeat * protocol_.episodes +
                        static_cast<int>(item.first_seed - protocol_.start_seed) +
                        in.get<std::int32_t>();
    const Bytes record(in.rest().begin(), in.rest().end());
    if (journal_ != nullptr) journal_->add(entry_at(item.task).id, episode, record);
    take(item.task, episode, record);
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

  // The episodes that the journal has.
  void take_known(const std::vector<const RegistryEntry*>& tasks) {
    for (const RegistryEntry* task : tasks) {
      const auto known = journal_->records().find(std::string(task->id));
      if (known == journal_->records().end()) continue;
      for (const auto& [episode, record] : known->second) {
        if (episode < 0 || episode >= protocol_.all_episodes()) continue;
        queue_.remove(task->index, episode);
        take(task->index, episode, record);
      }
    }
  }

  void take(int row, int episode, const Bytes& bytes) {
    const EpisodeRecord record = EpisodeRecord::unpack(bytes);
    Partial& partial = partial_of(row);
    TaskResult& result = partial.result;
    const auto i = static_cast<std::size_t>(episode);
    result.successes[i] = record.result.success != 0;
    result.returns[i] = record.result.episode_return;
    result.lengths[i] = record.result.length;
    result.digests[i] = record.result.digests;
    if (record.has_answers != 0) {
      result.answers.resize(result.successes.size());
      result.answers[i] = record.result.answer;
    }
    if (record.has_subtasks != 0) {
      result.completions.resize(result.successes.size());
      result.completions[i] = record.result.completion;
    }
    result.chance = record.chance;
    result.answer_chance = record.answer_chance;
    result.chunk_size = std::max(result.chunk_size, static_cast<int>(record.chunk_size));
    result.unstable += record.unstable;
    result.thread_seconds += record.seconds;
    if (!record.sample.empty()) result.sample = record.sample;
    ++status_.episodes;
    if (++partial.episodes < protocol_.all_episodes()) return;
    ++status_.tasks;
    TaskResult whole = std::move(result);
    results_.erase(row);
    if (listener_.finished) listener_.finished(std::move(whole));
  }

  Partial& partial_of(int row) {
    const auto [found, added] = results_.try_emplace(row);
    if (!added) return found->second;
    TaskResult& result = found->second.result;
    const auto count = static_cast<std::size_t>(protocol_.all_episodes());
    result.entry = &entry_at(row);
    result.successes.resize(count);
    result.returns.resize(count);
    result.lengths.resize(count);
    result.digests.resize(count);
    for (int i = 0; i < protocol_.all_episodes(); ++i) {
      result.seeds.push_back(protocol_.start_seed +
                             static_cast<std::uint64_t>(i % protocol_.episodes));
    }
    return found->second;
  }

  const Protocol& protocol_;
  const EvaluationListener& listener_;
  Journal* journal_;
  EpisodeQueue queue_;
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

std::vector<TaskLoad> loads_of(const std::vector<const RegistryEntry*>& tasks,
                               const RunOptions& options) {
  std::vector<TaskLoad> loads;
  for (const RegistryEntry* task : tasks) {
    loads.push_back({options.all_episodes(), task->horizon});
  }
  return loads;
}

void evaluate(Ranks& ranks, const std::vector<const RegistryEntry*>& tasks,
              const Protocol& protocol, const EvaluationListener& listener,
              const EpisodeStore& store) {
  ItemEvaluator evaluator(protocol, worker_threads(protocol.threads, ranks));
  Evaluation evaluation(tasks, protocol, listener, store);
  distribute_work(
      ranks, protocol.threads,
      [&evaluator](const WorkItem& item, const WorkContext& context) {
        evaluator.evaluate(item, context);
      },
      evaluation);
}

}  // namespace engram
