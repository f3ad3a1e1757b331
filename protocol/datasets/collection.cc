#include "protocol/datasets/collection.h"

#include <algorithm>
#include <limits>

#include "core/batch/scripted_policy.h"
#include "protocol/datasets/plan_document.h"
#include "protocol/io/files.h"
#include "protocol/make/episodes.h"
#include "protocol/parallel/episode_queue.h"
#include "protocol/parallel/scheduler.h"

namespace engram {
namespace {

using Folders = std::vector<std::unique_ptr<DemonstrationFolder>>;

// Records the episodes of one item, as play_episodes plays them, and emits each: its number in the
// item, and its demonstration.
struct EpisodeRecorder {
  const Batch& batch;
  std::vector<DemonstrationRecorder> recorders;  // one per environment
  const WorkContext& context;
  NpzCompression compression;
  bool keep_failures;

  void start(int env, int /*episode*/) { recorder_of(env).start(batch, env); }
  void before_step(int env, std::span<float> action) {
    recorder_of(env).before_step(batch, env, action);
  }
  void after_step(int env) { recorder_of(env).after_step(batch, env); }
  void finish(int env, int episode) {
    ByteWriter out;
    out.put(static_cast<std::int32_t>(episode));
    recorder_of(env).finish(compression, keep_failures).pack(out);
    context.emit(out.take());
  }
  DemonstrationRecorder& recorder_of(int env) { return recorders[static_cast<std::size_t>(env)]; }
};

// Source of seeds, attempt by attempt, while episodes are missing; passes results to the folders.
class SeedSource : public WorkSource {
 public:
  SeedSource(Folders& folders, const CollectionOptions& options,
             const std::function<void(const CollectionProgress&)>& progress)
      : options_(options), progress_(progress) {
    int number = 0;
    for (const auto& folder : folders) {
      queues_.push_back({folder.get(), number++, folder->next_seed(), 0});
      before_ += folder->episodes();
    }
    std::stable_sort(queues_.begin(), queues_.end(), [](const Queue& a, const Queue& b) {
      return a.folder->entry().horizon > b.folder->entry().horizon;
    });
  }

  std::optional<WorkItem> next() override {
    for (Queue& queue : queues_) {
      const DemonstrationFolder& folder = *queue.folder;
      if (folder.finished() || queue.next >= folder.end_seed()) continue;
      if (folder.episodes() + folder.waiting() + queue.in_progress >= options_.plan.episodes) {
        continue;
      }
      while (queue.next < folder.end_seed() && folder.knows(queue.next)) ++queue.next;
      if (queue.next >= folder.end_seed()) continue;
      const std::uint64_t first = queue.next;
      const std::uint64_t end = folder.attempt_end(first);
      while (queue.next < end && !folder.knows(queue.next)) ++queue.next;
      const auto count = static_cast<int>(queue.next - first);
      queue.in_progress += count;
      return WorkItem{queue.task, first, count};
    }
    return std::nullopt;
  }

  void accept(const WorkItem& item, Bytes result) override {
    Queue& queue = queue_of(item);
    --queue.in_progress;
    ByteReader in(result);
    const std::uint64_t seed = item.first_seed + static_cast<std::uint64_t>(in.get<std::int32_t>());
    Demonstration demonstration = Demonstration::unpack(in);
    env_steps_ += static_cast<std::uint64_t>(demonstration.length);
    queue.folder->accept(seed, std::move(demonstration));
  }

  bool obsolete(const WorkItem& item) override { return queue_of(item).folder->finished(); }

  void tick(const WorkStatus& status) override { report_progress(status.env_steps); }
  // Reports the final numbers, when all work is done.
  void finish() const { report_progress(env_steps_); }

 private:
  struct Queue {
    DemonstrationFolder* folder = nullptr;
    int task = 0;
    std::uint64_t next = 0;  // first seed that is not assigned yet
    int in_progress = 0;     // episodes
  };

  void report_progress(std::uint64_t env_steps) const {
    CollectionProgress now;
    now.env_steps = env_steps;
    now.added = -before_;
    for (const Queue& queue : queues_) {
      now.episodes += std::min(queue.folder->episodes(), options_.plan.episodes);
      now.wanted += options_.plan.episodes;
      now.added += queue.folder->episodes();
    }
    progress_(now);
  }

  Queue& queue_of(const WorkItem& item) {
    return *std::find_if(queues_.begin(), queues_.end(),
                         [&](const Queue& queue) { return queue.task == item.task; });
  }

  const CollectionOptions& options_;
  const std::function<void(const CollectionProgress&)>& progress_;
  std::vector<Queue> queues_;    // long episodes first
  std::uint64_t env_steps_ = 0;  // steps of all results so far
  int before_ = 0;               // episodes that were there already
};

// Plays items on worker threads.
class ItemRecorder {
 public:
  ItemRecorder(std::span<const RegistryEntry* const> tasks, const CollectionOptions& options,
               int workers)
      : tasks_(tasks),
        options_(options),
        environment_(demonstration_options(options.plan.additions)),
        batches_(static_cast<std::size_t>(workers)) {
    options.plan.set_environment(environment_);
  }

  void play(const WorkItem& item, const WorkContext& context) {
    const RegistryEntry& task = *tasks_[static_cast<std::size_t>(item.task)];
    EpisodeBatch& reusable = batches_[static_cast<std::size_t>(context.worker())];
    Batch& batch = reusable.of(task.id, item.count, options_.num_envs, environment_);
    EpisodeRecorder recorder{
        batch,
        std::vector<DemonstrationRecorder>(static_cast<std::size_t>(batch.num_envs()),
                                           DemonstrationRecorder(options_.plan.additions)),
        context, options_.sink ? NpzCompression::kStored : NpzCompression::kDeflated,
        options_.plan.keep_failures};
    const ScriptedPolicy oracle(batch, Policy::kOracle);
    const auto act = [&oracle](std::span<float> actions) { oracle.act(actions); };
    if (!play_episodes(batch, item.first_seed, item.count, context, act, recorder)) {
      reusable.clear();
    }
  }

 private:
  std::span<const RegistryEntry* const> tasks_;
  const CollectionOptions& options_;
  MakeOptions environment_;
  std::vector<EpisodeBatch> batches_;
};

void record_all(Ranks& ranks, std::span<const RegistryEntry* const> tasks,
                const CollectionOptions& options, WorkSource& source) {
  ItemRecorder recorder(tasks, options, worker_threads(options.threads, ranks));
  distribute_work(
      ranks, options.threads,
      [&recorder](const WorkItem& item, const WorkContext& context) {
        recorder.play(item, context);
      },
      source);
}

// Hands out the episodes of a shard, and keeps all of their results.
class ShardSource final : public WorkSource {
 public:
  ShardSource(std::span<const RegistryEntry* const> tasks, const CollectionOptions& options,
              const std::filesystem::path& folder, const RunHeader& header, Journal& journal,
              const std::function<void(const CollectionProgress&)>& progress)
      : options_(options), progress_(progress), queue_(kBlock, std::numeric_limits<int>::max()) {
    const std::vector<EpisodeRange> share =
        share_of(header.loads(), header.shard.value_or(Shard()));
    for (std::size_t i = 0; i < tasks.size(); ++i) {
      const std::filesystem::path path = shard_task_folder(folder, *tasks[i]);
      require_writable_folder(path);
      folders_.push_back(std::make_unique<OpenFolder>(path));
      episodes_.emplace_back(*folders_.back(), journal, tasks[i]->id);
      queue_.add(static_cast<int>(i), share[i]);
      now_.wanted += share[i].size();
      for (const auto& [episode, known] : episodes_.back().known()) {
        queue_.remove(static_cast<int>(i), episode);
        ++now_.episodes;
      }
    }
  }

  std::optional<WorkItem> next() override {
    const auto block = queue_.next();
    if (!block) return std::nullopt;
    return WorkItem{block->task,
                    options_.plan.start_seed + static_cast<std::uint64_t>(block->first),
                    block->count};
  }

  void accept(const WorkItem& item, Bytes result) override {
    ByteReader in(result);
    const int episode =
        static_cast<int>(item.first_seed - options_.plan.start_seed) + in.get<std::int32_t>();
    episodes_[static_cast<std::size_t>(item.task)].add(episode, Demonstration::unpack(in));
    ++now_.episodes;
    ++now_.added;
  }

  void tick(const WorkStatus& status) override {
    now_.env_steps = status.env_steps;
    progress_(now_);
  }

 private:
  static constexpr int kBlock = 10;  // episodes of an item

  const CollectionOptions& options_;
  const std::function<void(const CollectionProgress&)>& progress_;
  EpisodeQueue queue_;
  std::vector<std::unique_ptr<OpenFolder>> folders_;  // by task
  std::vector<FinishedEpisodes> episodes_;
  CollectionProgress now_;
};

}  // namespace

std::vector<std::unique_ptr<DemonstrationFolder>> collect(
    Ranks& ranks, std::span<const RegistryEntry* const> tasks, const CollectionOptions& options,
    const std::function<void(const CollectionProgress&)>& progress) {
  Folders folders;
  if (ranks.is_root()) {
    for (const RegistryEntry* task : tasks) {
      folders.push_back(
          options.sink ? std::make_unique<DemonstrationFolder>(options.sink, *task, options.plan)
                       : std::make_unique<DemonstrationFolder>(options.out, *task, options.plan));
    }
  }
  SeedSource source(folders, options, progress);
  record_all(ranks, tasks, options, source);
  if (ranks.is_root()) source.finish();
  return folders;
}

// --- shards ---

std::filesystem::path shard_task_folder(const std::filesystem::path& shard,
                                        const RegistryEntry& task) {
  return shard / "data_npz" / task.id;
}

RunHeader shard_header(std::span<const RegistryEntry* const> tasks, const CollectionPlan& plan,
                       const EpisodePart& part) {
  RunHeader header{.kind = kCollectionKind,
                   .shard = part.shard,
                   .command = part.command,
                   .run = plan_document(tasks, plan),
                   .tasks = {}};
  for (const RegistryEntry* task : tasks) {
    const int batch = rule_of(*task, plan).batch;
    const int attempts = (plan.episodes - 1) / batch + 1;
    header.tasks.push_back({std::string(task->id), {attempts * batch, task->horizon}});
  }
  return header;
}

void collect_shard(Ranks& ranks, std::span<const RegistryEntry* const> tasks,
                   const CollectionOptions& options, const std::filesystem::path& folder,
                   const RunHeader& header, Journal* journal,
                   const std::function<void(const CollectionProgress&)>& progress) {
  if (!ranks.is_root()) {
    Folders none;
    SeedSource unused(none, options, progress);
    record_all(ranks, tasks, options, unused);
    return;
  }
  ShardSource source(tasks, options, folder, header, *journal, progress);
  record_all(ranks, tasks, options, source);
}

}  // namespace engram
