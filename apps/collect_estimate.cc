#include "apps/collect_estimate.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <filesystem>

#include "apps/output.h"
#include "protocol/parallel/scheduler.h"

namespace engram::apps {
namespace {

namespace fs = std::filesystem;

constexpr double kMebibyte = 1 << 20;
constexpr int kMaxAttempts = 20;

class ScratchFolder {
 public:
  ScratchFolder() {
    std::string name = (fs::temp_directory_path() / "engram-estimate-XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr) {
      throw Error(Error::kIo, "'" + name + "' cannot be made: no temporary folder");
    }
    path_ = name;
  }
  ~ScratchFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;

  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

CollectEstimate::Task estimate_task(const RegistryEntry& task, const CollectionOptions& options,
                                    const Interruption& interruption) {
  const ScratchFolder scratch;
  CollectionOptions first = options;
  first.out = scratch.path();
  first.threads = 1;
  first.plan.max_attempts = std::min(options.plan.max_attempts, kMaxAttempts);
  // One attempt can keep as many.
  first.plan.episodes =
      std::min(options.plan.episodes,
               collection_rule(task, options.plan.control_mode.value_or(task.control_mode)).batch);
  Ranks alone;
  const RegistryEntry* const tasks[] = {&task};
  const auto start = std::chrono::steady_clock::now();
  const auto folders = collect(alone, tasks, first, [&](const CollectionProgress&) {
    interruption.check("nothing was written");
  });
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
  const DemonstrationFolder& folder = *folders.front();
  if (folder.episodes() == 0) {
    throw Error(Error::kUnavailable, fmt::format("{}: no episode kept in {} attempts; nothing to "
                                                 "estimate from",
                                                 task.id, first.plan.max_attempts));
  }
  double bytes = 0;
  for (int i = 0; i < folder.episodes(); ++i) {
    bytes += static_cast<double>(fs::file_size(folder.file(i)));
  }
  const double times = static_cast<double>(options.plan.episodes) / folder.episodes();
  return {std::string(task.id), times * static_cast<double>(folder.steps()), times * bytes,
          times * seconds.count()};
}

std::string duration(double seconds) {
  if (seconds < 120) return fmt::format("{:.0f} s", std::max(seconds, 1.0));
  return fmt::format("{:.0f} minutes", seconds / 60);
}

}  // namespace

double CollectEstimate::bytes() const {
  double sum = 0;
  for (const Task& task : tasks) sum += task.bytes;
  return sum;
}

double CollectEstimate::seconds() const {
  double sum = 0;
  for (const Task& task : tasks) sum += task.thread_seconds;
  return sum / threads;
}

Json CollectEstimate::document() const {
  JsonList list;
  for (const Task& task : tasks) {
    list.emplace_back(JsonTable{{"env_id", task.id},
                                {"episodes", episodes},
                                {"steps", task.steps},
                                {"bytes", task.bytes},
                                {"thread_seconds", task.thread_seconds}});
  }
  return JsonTable{
      {"bytes", bytes()}, {"seconds", seconds()}, {"threads", threads}, {"tasks", std::move(list)}};
}

std::string CollectEstimate::text() const {
  Table table({{"task"}, {"episodes", true}, {"steps", true}, {"MB", true}, {"thread s", true}});
  for (const Task& task : tasks) {
    table.add({task.id, std::to_string(episodes), with_thousands(task.steps),
               fmt::format("{:.1f}", task.bytes / kMebibyte),
               fmt::format("{:.1f}", task.thread_seconds)});
  }
  return table.text() + fmt::format(
                            "about {:.0f} MB and {} with {} threads, by the first attempts "
                            "of each task; nothing was written\n",
                            std::max(bytes() / kMebibyte, 1.0), duration(seconds()), threads);
}

CollectEstimate estimate_collection(std::span<const RegistryEntry* const> tasks,
                                    const CollectionOptions& options,
                                    const Interruption& interruption) {
  CollectEstimate estimate;
  estimate.episodes = options.plan.episodes;
  estimate.threads = worker_threads(options.threads, Ranks());
  for (const RegistryEntry* task : tasks) {
    estimate.tasks.push_back(estimate_task(*task, options, interruption));
  }
  return estimate;
}

}  // namespace engram::apps
