#include "protocol/datasets/collection.h"

#include <algorithm>
#include <utility>

#include "core/batch/scripted_policy.h"
#include "protocol/make/episodes.h"
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
      const std::uint64_t end = folder.attempt_end(queue.next);
      const auto count = static_cast<int>(end - queue.next);
      queue.in_progress += count;
      return WorkItem{queue.task, std::exchange(queue.next, end), count};
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
  MakeOptions env_options = demonstration_options(options.plan.additions);
  options.plan.set_environment(env_options);
  std::vector<EpisodeBatch> batches(
      static_cast<std::size_t>(worker_threads(options.threads, ranks)));
  const auto work = [&](const WorkItem& item, const WorkContext& context) {
    const RegistryEntry& task = *tasks[static_cast<std::size_t>(item.task)];
    EpisodeBatch& reusable = batches[static_cast<std::size_t>(context.worker())];
    Batch& batch = reusable.of(task.id, item.count, options.num_envs, env_options);
    EpisodeRecorder recorder{
        batch,
        std::vector<DemonstrationRecorder>(static_cast<std::size_t>(batch.num_envs()),
                                           DemonstrationRecorder(options.plan.additions)),
        context, options.sink ? NpzCompression::kStored : NpzCompression::kDeflated,
        options.plan.keep_failures};
    const ScriptedPolicy oracle(batch, Policy::kOracle);
    const auto act = [&oracle](std::span<float> actions) { oracle.act(actions); };
    if (!play_episodes(batch, item.first_seed, item.count, context, act, recorder)) {
      reusable.clear();
    }
  };
  SeedSource source(folders, options, progress);
  distribute_work(ranks, options.threads, work, source);
  if (ranks.is_root()) source.finish();
  return folders;
}

}  // namespace engram
