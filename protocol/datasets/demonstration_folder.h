// The folder of one task's demonstrations: files numbered without gaps, and metadata.json.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "protocol/datasets/finished_episodes.h"
#include "protocol/datasets/recorder.h"
#include "protocol/io/folder_lock.h"
#include "protocol/io/json.h"

namespace engram {

// Throws Error (kInvalidArgument) unless `count` seeds from the first one on can be stored.
void require_storable_seeds(std::uint64_t first, std::uint64_t count);

// Kind of a run, in journals.
inline constexpr const char* kCollectionKind = "collect";

struct CollectionPlan {
  int episodes = 250;
  int max_attempts = 5000;
  std::uint64_t start_seed = 0;
  std::string renderer = "cpu";
  Rules rules = Rules::kReference;
  std::optional<ControlMode> control_mode = std::nullopt;  // none: each task's own
  bool joint_proprio = false;
  Physics physics = Physics::kEngram;
  bool keep_failures = false;    // episodes that fail are demonstrations too
  ConstantTable constants = {};  // of all tasks, instead of their own
  std::vector<PerturbationLevel> perturbations = {};
  Additions additions = {};

  // Sets what does not depend on the layout of the data.
  void set_environment(MakeOptions& options) const;
};

// The rule for the episodes of a task that the plan keeps.
CollectionRule rule_of(const RegistryEntry& entry, const CollectionPlan& plan);

// Provenance of the episodes in a folder. A run that continues a folder must agree.
JsonTable provenance(const RegistryEntry& entry, const CollectionPlan& plan);
// Throws Error (kInvalidArgument) unless the folder's provenance, as found, is that of the plan.
void require_same_provenance(const std::filesystem::path& folder, const Json& found,
                             const RegistryEntry& entry, const CollectionPlan& plan);

// Takes the content of a data file, in place of a folder.
using DemonstrationSink = std::function<void(std::span<const std::byte> file)>;

// Takes the result of each seed and writes the episodes to keep in the order of their seeds. So the
// files do not depend on which thread played a seed, or when. Every file appears at once and
// complete: after any interruption the folder can be opened again with the same plan, and knows the
// seeds that have been played.
class DemonstrationFolder {
 public:
  // Makes or opens <root>/data_npz/<id>. Throws Error: kIo if it cannot be written, is in use by
  // another run, or holds damaged files or numbers with gaps; kInvalidArgument if what it holds was
  // collected with another plan.
  DemonstrationFolder(const std::filesystem::path& root, const RegistryEntry& entry,
                      const CollectionPlan& plan);
  // Without a folder: passes the content of each file to `sink`, in their order.
  DemonstrationFolder(DemonstrationSink sink, const RegistryEntry& entry,
                      const CollectionPlan& plan);

  const RegistryEntry& entry() const { return entry_; }
  const std::filesystem::path& path() const { return path_; }
  // The data file of that number.
  std::filesystem::path file(int index) const;

  // complete: all planned episodes are there; finished: no seed is left to be played.
  bool complete() const { return episodes() >= plan_.episodes; }
  bool finished() const { return complete() || attempt_of(next_) >= plan_.max_attempts; }

  // The first seed that is still to be played; those after it follow one by one.
  std::uint64_t next_seed() const { return next_; }
  // The end of the seeds of an attempt, and of those that may be played at all.
  std::uint64_t attempt_end(std::uint64_t seed) const;
  std::uint64_t end_seed() const;
  // True if the result of a seed from next_seed() on is there.
  bool knows(std::uint64_t seed) const { return waiting_.contains(seed); }
  // Takes the result of a seed from next_seed() on, each once. Writes files when the results of all
  // seeds before are known. Ignored when finished. Throws Error (kIo) if a file cannot be written.
  void accept(std::uint64_t seed, Demonstration demonstration);
  // Takes those of a shard: episode i has the plan's first seed + i.
  void accept(const FinishedEpisodes& shard);

  // Successes that wait for the results of earlier seeds.
  int waiting() const;

  // Kept episodes and their control steps.
  int episodes() const { return static_cast<int>(kept_.size()); }
  std::int64_t steps() const;
  std::vector<int> lengths() const;
  // Attempts up to the last one with a kept episode, and how many of them were kept.
  int attempts() const;
  int attempts_kept() const;
  // The content of metadata.json.
  Json metadata() const;

 private:
  struct Kept {
    std::int64_t seed = 0;
    std::int32_t length = 0;
    double reward_sum = 0;
    bool success = true;
  };

  int attempt_of(std::uint64_t seed) const;
  void check_metadata() const;
  int count_files() const;
  Kept read(int index) const;
  void open_journal();
  int episode_of(std::uint64_t seed) const;
  bool is_to_keep(const Demonstration& demonstration) const;
  bool is_dropped(std::uint64_t seed) const;
  void decide();
  bool decide_attempt();
  void keep(std::uint64_t seed, const Demonstration& demonstration);
  void check_plan() const;
  void write_metadata();

  const RegistryEntry& entry_;
  CollectionPlan plan_;
  CollectionRule rule_;
  std::filesystem::path path_;
  std::unique_ptr<FolderLock> lock_;  // null with a sink
  DemonstrationSink sink_;
  std::vector<Kept> kept_;
  std::size_t described_ = 0;  // in the metadata, of those that are kept
  std::uint64_t next_ = 0;
  // For seeds before them; without the contents of files that the journal has.
  std::map<std::uint64_t, Demonstration> waiting_;
  std::unique_ptr<Journal> journal_;
  std::optional<FinishedEpisodes> finished_episodes_;  // of the journal
};

}  // namespace engram
