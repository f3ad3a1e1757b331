// The folder of one task's episodes in the layout of the benchmark's RL data (docs/datasets.md):
// arrays alone, of whole episodes, successful or not.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <vector>

#include "protocol/datasets/demonstration_folder.h"
#include "protocol/io/folder_lock.h"
#include "protocol/make/make.h"

namespace engram {

// Episodes of a task in the published data.
inline constexpr int kRlEpisodes = 1000;

// Options of the environments for recording: images, and episodes that go on to their horizon.
MakeOptions rl_recording_options(const CollectionPlan& plan);

// Records the episode of one environment of a batch from its first observation to its horizon.
class RlRecorder {
 public:
  // After the environment's reset.
  void start();
  // Before a step: keeps the observation, and the action as it is.
  void before_step(const Batch& batch, int index, std::span<const float> action);
  // After it.
  void after_step(const Batch& batch, int index);
  // The .npz file's content, not compressed. Throws Error (kUnavailable) if the episode is shorter
  // than the task's horizon.
  std::vector<std::byte> file(const Batch& batch) const;

 private:
  std::vector<std::uint8_t> rgb_;
  std::vector<float> joints_;
  std::vector<float> actions_;
  std::vector<float> rewards_;
  std::vector<std::int64_t> successes_;
  std::vector<std::int64_t> dones_;
};

class RlFolder {
 public:
  // Reads <root>/MIKASA-Robo/unbatched/<id>; <root>/MIKASA-Robo/<id>.json holds the plan. Writes
  // nothing. Throws Error: kInvalidArgument if what is there was collected with another plan or by
  // another program, or for additions or joint_proprio; kIo if a file of the plan
  // is damaged.
  RlFolder(const std::filesystem::path& root, const RegistryEntry& entry,
           const CollectionPlan& plan);
  // Makes or opens the folder, before anything is written. Throws Error (kIo) if it cannot be
  // written or is in use by another run.
  void open();

  const RegistryEntry& entry() const { return *entry_; }
  const std::filesystem::path& path() const { return path_; }

  int episodes() const;  // files of the plan that are there
  std::int64_t steps() const { return std::int64_t{horizon_} * episodes(); }
  int horizon() const { return horizon_; }  // control steps of each
  // The episodes that are missing: the first of them from `from` on, or the planned number.
  int next_missing(int from) const;
  bool has(int episode) const { return present_[static_cast<std::size_t>(episode)] != 0; }
  std::uint64_t seed(int episode) const {
    return plan_.start_seed + static_cast<std::uint64_t>(episode);
  }
  // Writes the file of an episode. Throws Error (kIo) if that fails.
  void write(int episode, std::span<const std::byte> file);
  // Share of the episodes that are there which succeeded in some step.
  double success_once() const;

 private:
  std::filesystem::path file(int episode) const;
  void check_plan() const;
  void find_episodes();

  const RegistryEntry* entry_;
  CollectionPlan plan_;
  int horizon_ = 0;
  std::filesystem::path path_;
  std::filesystem::path note_;  // of the plan
  std::unique_ptr<FolderLock> lock_;
  std::vector<std::uint8_t> present_;  // by episode
};

}  // namespace engram
