#include "protocol/datasets/rl_collection.h"

#include <algorithm>

#include "core/batch/scripted_policy.h"
#include "protocol/make/episodes.h"
#include "protocol/parallel/scheduler.h"

namespace engram {
namespace {

using RlFolders = std::vector<std::unique_ptr<RlFolder>>;

// Episodes of an item.
constexpr int kMaxEpisodes = 10;

struct RlEpisodeRecorder {
  const Batch& batch;
  std::vector<RlRecorder> recorders;  // one per environment
  const WorkContext& context;

  void start(int env, int /*episode*/) { of(env).start(); }
  void before_step(int env, std::span<const float> action) {
    of(env).before_step(batch, env, action);
  }
  void after_step(int env) { of(env).after_step(batch, env); }
  void finish(int env, int episode) {
    ByteWriter out;
    out.put(static_cast<std::int32_t>(episode));
    const std::vector<std::byte> file = of(env).file(batch);
    out.append(std::span<const std::byte>(file));
    context.emit(out.take());
  }
  RlRecorder& of(int env) { return recorders[static_cast<std::size_t>(env)]; }
};

// Source of missing episodes, task by task; passes files to the folders.
class EpisodeSource : public WorkSource {
 public:
  EpisodeSource(RlFolders& folders, const CollectionOptions& options,
                const std::function<void(const CollectionProgress&)>& progress)
      : folders_(folders), options_(options), progress_(progress) {
    for (const auto& folder : folders) before_ += folder->episodes();
  }

  std::optional<WorkItem> next() override {
    const int planned = options_.plan.episodes;
    for (; task_ < folders_.size(); ++task_, episode_ = 0) {
      const RlFolder& folder = *folders_[task_];
      const int first = folder.next_missing(episode_);
      if (first == planned) continue;
      int end = first;
      while (end < planned && end - first < kMaxEpisodes && !folder.has(end)) ++end;
      episode_ = end;
      return WorkItem{static_cast<int>(task_), folder.seed(first), end - first};
    }
    return std::nullopt;
  }

  void accept(const WorkItem& item, Bytes result) override {
    RlFolder& folder = *folders_[static_cast<std::size_t>(item.task)];
    const auto first = static_cast<int>(item.first_seed - folder.seed(0));
    ByteReader in(result);
    const auto episode = in.get<std::int32_t>();
    folder.write(first + episode, in.rest());
    env_steps_ += static_cast<std::uint64_t>(folder.horizon());
  }

  void tick(const WorkStatus& status) override { report_progress(status.env_steps); }
  // Reports the final numbers, when all work is done.
  void finish() const { report_progress(env_steps_); }

 private:
  void report_progress(std::uint64_t env_steps) const {
    CollectionProgress now;
    now.env_steps = env_steps;
    for (const auto& folder : folders_) now.episodes += folder->episodes();
    now.wanted = options_.plan.episodes * static_cast<int>(folders_.size());
    now.added = now.episodes - before_;
    progress_(now);
  }

  RlFolders& folders_;
  const CollectionOptions& options_;
  const std::function<void(const CollectionProgress&)>& progress_;
  std::size_t task_ = 0;
  int episode_ = 0;              // the next one of that task
  int before_ = 0;               // episodes that were there already
  std::uint64_t env_steps_ = 0;  // of all results so far
};

}  // namespace

std::vector<std::unique_ptr<RlFolder>> collect_rl(
    Ranks& ranks, std::span<const RegistryEntry* const> tasks, const CollectionOptions& options,
    const std::function<void(const CollectionProgress&)>& progress) {
  RlFolders folders;
  if (ranks.is_root()) {
    for (const RegistryEntry* task : tasks) {
      folders.push_back(std::make_unique<RlFolder>(options.out, *task, options.plan));
    }
    for (const auto& folder : folders) folder->open();
  }
  const MakeOptions env_options = rl_recording_options(options.plan);
  std::vector<EpisodeBatch> batches(
      static_cast<std::size_t>(worker_threads(options.threads, ranks)));
  const auto work = [&](const WorkItem& item, const WorkContext& context) {
    const RegistryEntry& task = *tasks[static_cast<std::size_t>(item.task)];
    EpisodeBatch& reusable = batches[static_cast<std::size_t>(context.worker())];
    Batch& batch = reusable.of(task.id, item.count, options.num_envs, env_options);
    RlEpisodeRecorder recorder{
        batch, std::vector<RlRecorder>(static_cast<std::size_t>(batch.num_envs())), context};
    const ScriptedPolicy oracle(batch, Policy::kOracle);
    const auto act = [&oracle](std::span<float> actions) { oracle.act(actions); };
    if (!play_episodes(batch, item.first_seed, item.count, context, act, recorder)) {
      reusable.clear();
    }
  };
  EpisodeSource source(folders, options, progress);
  distribute_work(ranks, options.threads, work, source);
  if (ranks.is_root()) source.finish();
  return folders;
}

}  // namespace engram
