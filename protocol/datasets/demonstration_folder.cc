#include "protocol/datasets/demonstration_folder.h"

#include <algorithm>
#include <charconv>
#include <cstring>
#include <limits>
#include <optional>

#include "core/batch/scripted_policy.h"
#include "protocol/datasets/npz.h"
#include "protocol/io/files.h"
#include "protocol/io/json_checksum.h"
#include "protocol/io/json_values.h"
#include "protocol/make/definitions.h"
#include "protocol/make/perturbations_document.h"
#include "protocol/make/physics_keys.h"
#include "protocol/make/variants.h"
#include "protocol/parallel/run_header.h"

namespace engram {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kFilePrefix = "train_data_";
constexpr std::string_view kFileSuffix = ".npz";
constexpr const char* kMetadata = "metadata.json";
// In the metadata of folders that have them.
constexpr const char* kDefinition = "definition";
constexpr const char* kLabels = "labels";
constexpr const char* kDepth = "depth";
constexpr const char* kSegmentation = "segmentation";
constexpr const char* kState = "state";
constexpr const char* kObjects = "objects";

[[noreturn]] void fail(const fs::path& path, const std::string& what) {
  throw Error(Error::kIo, "'" + path.string() + "' " + what);
}

// The number in the name of a data file, or -1.
int file_number(const std::string& name) {
  if (!name.starts_with(kFilePrefix) || !name.ends_with(kFileSuffix)) return -1;
  const char* const begin = name.data() + kFilePrefix.size();
  const char* const end = name.data() + name.size() - kFileSuffix.size();
  int number = -1;
  const auto [last, error] = std::from_chars(begin, end, number);
  return error == std::errc() && last == end ? number : -1;
}

std::string text_of(const Json& document, std::string_view key) {
  const Json* found = find(document, key);
  return found == nullptr ? std::string() : to_line(*found);
}

[[noreturn]] void refuse_addition(const fs::path& path, const std::string& what, bool asked_for) {
  const std::string which[] = {"without " + what, "with " + what};
  throw Error(Error::kInvalidArgument,
              "'" + path.string() + "' was collected " + which[asked_for ? 0 : 1] + ", " +
                  which[asked_for ? 1 : 0] + " given; the same, or another folder, allowed");
}

// Names of the labels.
Json label_document(const RegistryEntry& entry, const CollectionPlan& plan) {
  const auto task = make_task(entry.id, plan.constants);
  return JsonTable{{"privileged", to_list(privileged_labels(task->info()))},
                   {"open", to_list(open_labels())}};
}

// What is said of additions; null of those that are not asked for.
JsonTable addition_documents(const RegistryEntry& entry, const CollectionPlan& plan) {
  const Additions& asked = plan.additions;
  return {{kLabels, asked.labels ? label_document(entry, plan) : Json()},
          {kDepth, asked.depth ? Json(true) : Json()},
          {kSegmentation, asked.segmentation ? Json(true) : Json()},
          {kState, asked.state ? Json(true) : Json()},
          {kObjects, asked.objects ? Json(true) : Json()}};
}

ControlMode control_mode_of(const RegistryEntry& entry, const CollectionPlan& plan) {
  return plan.control_mode.value_or(entry.control_mode);
}

}  // namespace

// Where failures are kept, no episode depends on others.
CollectionRule rule_of(const RegistryEntry& entry, const CollectionPlan& plan) {
  return plan.keep_failures ? CollectionRule{}
                            : collection_rule(entry, control_mode_of(entry, plan));
}

JsonTable provenance(const RegistryEntry& entry, const CollectionPlan& plan) {
  JsonTable made_how = {{"version", version()},
                        {"start_seed", plan.start_seed},
                        {"renderer", plan.renderer},
                        {"rules", name_of(plan.rules)},
                        {"control_mode", name_of(control_mode_of(entry, plan))},
                        {"joint_proprio", plan.joint_proprio},
                        {kPhysicsKey, name_of(plan.physics)},
                        {"keep_failures", plan.keep_failures},
                        {"reward_mode", "normalized_dense"},
                        {"variant", variant_document(entry, plan.constants)},
                        {"perturbations", perturbations_document(plan.perturbations)}};
  Json mujoco = mujoco_version_of(plan.physics);
  if (!is_null(mujoco)) made_how.emplace_back(kMujocoVersionKey, std::move(mujoco));
  Json definition = definition_of(entry);
  if (!is_null(definition)) made_how.emplace_back(kDefinition, std::move(definition));
  return made_how;
}

DemonstrationFolder::DemonstrationFolder(const fs::path& root, const RegistryEntry& entry,
                                         const CollectionPlan& plan)
    : entry_(entry),
      plan_(plan),
      rule_(rule_of(entry, plan)),
      path_(root / "data_npz" / entry.id),
      next_(plan.start_seed) {
  check_plan();  // before there is a folder
  require_writable_folder(path_);
  lock_ = std::make_unique<FolderLock>(path_);
  const int files = count_files();
  check_metadata();
  for (int i = 0; i < files; ++i) kept_.push_back(read(i));
  if (!kept_.empty()) next_ = static_cast<std::uint64_t>(kept_.back().seed) + 1;
  if (!complete() || fs::exists(path_ / kJournalFile)) open_journal();
  write_metadata();
  decide();
}

DemonstrationFolder::DemonstrationFolder(DemonstrationSink sink, const RegistryEntry& entry,
                                         const CollectionPlan& plan)
    : entry_(entry),
      plan_(plan),
      rule_(rule_of(entry, plan)),
      sink_(std::move(sink)),
      next_(plan.start_seed) {
  check_plan();
}

void CollectionPlan::set_environment(MakeOptions& options) const {
  options.image_options.renderer = renderer;
  options.rules = rules;
  options.control_mode = control_mode;
  options.joint_proprio = joint_proprio;
  options.physics = physics;
  options.constants = constants;
  options.perturbations = perturbations;
}

void DemonstrationFolder::check_plan() const {
  require_mode_of(Policy::kOracle, control_mode_of(entry_, plan_));
  (void)make_task(entry_.id, plan_.constants);
  require_storable_seeds(plan_.start_seed, end_seed() - plan_.start_seed);
}

void require_storable_seeds(std::uint64_t first, std::uint64_t count) {
  if (first <= kMaxDemonstrationSeed - count) return;
  throw Error(Error::kInvalidArgument, "seed " + std::to_string(first) + ": seeds up to " +
                                           std::to_string(kMaxDemonstrationSeed) +
                                           " allowed, and " + std::to_string(count) +
                                           " are planned");
}

void DemonstrationFolder::write_metadata() {
  if (lock_) lock_->folder().write_file(kMetadata, to_text(metadata()));
  described_ = kept_.size();
}

fs::path DemonstrationFolder::file(int index) const {
  return path_ / (std::string(kFilePrefix) + std::to_string(index) + std::string(kFileSuffix));
}

int DemonstrationFolder::attempt_of(std::uint64_t seed) const {
  return static_cast<int>((seed - plan_.start_seed) / static_cast<std::uint64_t>(rule_.batch));
}

std::uint64_t DemonstrationFolder::attempt_end(std::uint64_t seed) const {
  return plan_.start_seed +
         static_cast<std::uint64_t>(attempt_of(seed) + 1) * static_cast<std::uint64_t>(rule_.batch);
}

std::uint64_t DemonstrationFolder::end_seed() const {
  return plan_.start_seed +
         static_cast<std::uint64_t>(plan_.max_attempts) * static_cast<std::uint64_t>(rule_.batch);
}

// --- what is there already ---

int DemonstrationFolder::count_files() const {
  std::vector<int> numbers;
  for (const std::string& name : lock_->folder().names()) {
    if (!name.starts_with(kFilePrefix)) continue;
    const int number = file_number(name);
    if (number < 0 || path_ / name != file(number)) {
      fail(path_ / name, "is not a file of engram's: " + std::string(kFilePrefix) +
                             "<number>.npz without leading zeros expected");
    }
    numbers.push_back(number);
  }
  std::sort(numbers.begin(), numbers.end());
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    if (numbers[i] != static_cast<int>(i)) {
      fail(file(static_cast<int>(i)),
           "is missing, but there are files with higher numbers, up to " +
               std::to_string(numbers.back()) + "; numbers without gaps needed to go on");
    }
  }
  return static_cast<int>(numbers.size());
}

// Refuses to mix episodes of different plans. Without the file, those in the folder are trusted.
void require_same_provenance(const fs::path& folder, const Json& found, const RegistryEntry& entry,
                             const CollectionPlan& plan) {
  require_same_definition(std::string(entry.id), value_or_null(found, kDefinition),
                          "'" + folder.string() + "'", definition_of(entry));
  for (const auto& [key, value] : provenance(entry, plan)) {
    const Json before = key == kPhysicsKey ? physics_in(found) : value_or_null(found, key);
    if (before == value) continue;
    throw Error(Error::kInvalidArgument, "'" + folder.string() + "' was collected with " + key +
                                             " " + to_line(before) + ", " + to_line(value) +
                                             " given; the same, or another folder, allowed");
  }
}

void DemonstrationFolder::check_metadata() const {
  const fs::path path = path_ / kMetadata;
  const std::optional<std::string> text = lock_->folder().read_file(kMetadata);
  if (!text) return;
  const Json document = parse_json(*text).value_or(Json());
  const Json* id = find(document, "env_id");
  const Json* before = find(document, "engram");
  if (id == nullptr || *id != Json(entry_.id) || before == nullptr || !is_table(*before)) {
    fail(path, "is damaged or not engram's; without it, it is made anew from the data files");
  }
  if (text_of(*before, "version") == to_line(version()) && !has_valid_checksum(document)) {
    fail(path,
         "is damaged or edited, its checksum does not fit; without it, it is made anew from "
         "the data files");
  }
  require_same_provenance(path_, *before, entry_, plan_);
  for (const auto& [key, value] : addition_documents(entry_, plan_)) {
    if (value_or_null(*before, key) != value) refuse_addition(path_, key, value != Json());
  }
}

DemonstrationFolder::Kept DemonstrationFolder::read(int index) const {
  const NpzFile npz(file(index));
  Kept kept;
  kept.seed = npz.scalar<std::int64_t>("episode_seed", NpyType::kInt64);
  kept.length = npz.scalar<std::int32_t>("episode_length", NpyType::kInt32);
  kept.success = npz.scalar<bool>("success_once", NpyType::kBool);
  const std::int64_t shape[] = {kept.length};
  const std::vector<std::byte> rewards = npz.read("reward", NpyType::kFloat32, shape);
  std::vector<float> values(rewards.size() / sizeof(float));
  if (!values.empty()) std::memcpy(values.data(), rewards.data(), rewards.size());
  for (const float value : values) kept.reward_sum += static_cast<double>(value);
  const auto seed = static_cast<std::uint64_t>(kept.seed);
  const auto least =
      kept_.empty() ? plan_.start_seed : static_cast<std::uint64_t>(kept_.back().seed) + 1;
  // Attempts are counted by int.
  const std::uint64_t beyond =
      plan_.start_seed + static_cast<std::uint64_t>(std::numeric_limits<int>::max()) *
                             static_cast<std::uint64_t>(rule_.batch);
  std::vector<std::vector<std::int64_t>> shapes = {npz.shape("rgb", NpyType::kUint8)};
  if (plan_.additions.depth) shapes.push_back(npz.shape(kDepth, NpyType::kUint16));
  if (plan_.additions.segmentation) shapes.push_back(npz.shape(kSegmentation, NpyType::kUint16));
  if (plan_.additions.state) shapes.push_back(npz.shape(kState, NpyType::kFloat32));
  if (plan_.additions.objects) shapes.push_back(npz.shape(kObjects, NpyType::kFloat32));
  const bool same_length = std::ranges::all_of(
      shapes, [&](const auto& sizes) { return !sizes.empty() && sizes[0] == kept.length; });
  if (kept.length < 1 || !same_length) {
    fail(file(index), "is damaged: its arrays differ in length");
  }
  if (kept.seed < 0 || seed < least || seed >= beyond) {
    throw Error(Error::kInvalidArgument, "'" + file(index).string() + "' has seed " +
                                             std::to_string(kept.seed) + ", " +
                                             std::to_string(least) + " to " +
                                             std::to_string(beyond - 1) + " expected by this plan");
  }
  return kept;
}

// --- what is new ---

void DemonstrationFolder::open_journal() {
  JsonTable run = {{"env_id", entry_.id}, {"engram", provenance(entry_, plan_)}};
  for (auto& [key, value] : addition_documents(entry_, plan_)) run.emplace_back(key, value);
  const RunHeader header{
      .kind = kCollectionKind, .shard = {}, .command = {}, .run = std::move(run), .tasks = {}};
  journal_ = std::make_unique<Journal>(lock_->folder(), header.document());
  finished_episodes_.emplace(lock_->folder(), *journal_, entry_.id);
  for (auto& [episode, demonstration] : finished_episodes_->known()) {
    const std::uint64_t seed = plan_.start_seed + static_cast<std::uint64_t>(episode);
    if (seed >= next_) waiting_.emplace(seed, std::move(demonstration));
  }
  // A file that is needed and lost is played again.
  std::erase_if(waiting_, [this](const auto& item) {
    return is_to_keep(item.second) && !is_dropped(item.first) &&
           !finished_episodes_->has_file(episode_of(item.first));
  });
}

int DemonstrationFolder::episode_of(std::uint64_t seed) const {
  return static_cast<int>(seed - plan_.start_seed);
}

bool DemonstrationFolder::is_to_keep(const Demonstration& demonstration) const {
  return demonstration.success || plan_.keep_failures;
}

// True if an episode of the seed's attempt has failed, so that none of it is kept.
bool DemonstrationFolder::is_dropped(std::uint64_t seed) const {
  const std::uint64_t end = attempt_end(seed);
  auto one = waiting_.lower_bound(std::max(next_, end - static_cast<std::uint64_t>(rule_.batch)));
  for (; one != waiting_.end() && one->first < end; ++one) {
    if (!is_to_keep(one->second)) return true;
  }
  return false;
}

void DemonstrationFolder::accept(std::uint64_t seed, Demonstration demonstration) {
  if (finished() || seed < next_ || knows(seed)) return;
  // One that is decided at once becomes a data file at once.
  const bool now = rule_.batch == 1 && seed == next_ && is_to_keep(demonstration) &&
                   demonstration.length >= rule_.min_steps;
  if (finished_episodes_ && !now) {
    finished_episodes_->add(episode_of(seed), demonstration);
    demonstration.file.clear();
  }
  waiting_.emplace(seed, std::move(demonstration));
  decide();
}

void DemonstrationFolder::accept(const FinishedEpisodes& shard) {
  for (const auto& [episode, demonstration] : shard.known()) {
    const std::uint64_t seed = plan_.start_seed + static_cast<std::uint64_t>(episode);
    if (finished() || seed < next_ || knows(seed)) continue;
    finished_episodes_->add_from(shard, episode, demonstration);
    waiting_.emplace(seed, demonstration);
  }
  decide();
}

void DemonstrationFolder::decide() {
  while (!finished() && decide_attempt()) {
  }
  if (finished() && kept_.size() != described_) write_metadata();
  if (finished_episodes_ && complete()) finished_episodes_->clear();
}

// Keeps or drops the attempt that comes next; returns false if its episodes are not all there yet.
// An attempt that an interrupted run has kept in part continues with its rest.
bool DemonstrationFolder::decide_attempt() {
  const std::uint64_t end = attempt_end(next_);
  bool all_succeeded = true;
  for (std::uint64_t seed = next_; seed < end; ++seed) {
    const auto found = waiting_.find(seed);
    if (found == waiting_.end()) return false;
    all_succeeded = all_succeeded && found->second.success;
  }
  while (next_ < end) {
    const auto found = waiting_.find(next_);
    if ((all_succeeded || plan_.keep_failures) && found->second.length >= rule_.min_steps &&
        !complete()) {
      keep(next_, found->second);
    }
    waiting_.erase(found);
    ++next_;
  }
  return true;
}

void DemonstrationFolder::keep(std::uint64_t seed, const Demonstration& demonstration) {
  if (sink_) {
    sink_(demonstration.file);
  } else if (demonstration.file.empty()) {
    finished_episodes_->move_file(episode_of(seed), file(episodes()).filename());
  } else {
    lock_->folder().write_file(file(episodes()).filename(), demonstration.file);
  }
  kept_.push_back({static_cast<std::int64_t>(seed), demonstration.length, demonstration.reward_sum,
                   demonstration.success});
  // All of them on each change would cost the square of their number.
  const std::size_t more = kept_.size() - described_;
  if (complete() || more > described_ / 64) write_metadata();
}

int DemonstrationFolder::waiting() const {
  return static_cast<int>(std::count_if(waiting_.begin(), waiting_.end(), [this](const auto& item) {
    return is_to_keep(item.second);
  }));
}

std::int64_t DemonstrationFolder::steps() const {
  std::int64_t sum = 0;
  for (const Kept& kept : kept_) sum += kept.length;
  return sum;
}

std::vector<int> DemonstrationFolder::lengths() const {
  std::vector<int> lengths;
  for (const Kept& kept : kept_) lengths.push_back(kept.length);
  return lengths;
}

int DemonstrationFolder::attempts() const {
  return kept_.empty() ? 0 : attempt_of(static_cast<std::uint64_t>(kept_.back().seed)) + 1;
}

int DemonstrationFolder::attempts_kept() const {
  int count = 0;
  int last = -1;
  for (const Kept& kept : kept_) {
    const int attempt = attempt_of(static_cast<std::uint64_t>(kept.seed));
    if (attempt != last) ++count;
    last = attempt;
  }
  return count;
}

Json DemonstrationFolder::metadata() const {
  JsonList lengths;
  JsonList successes;
  JsonList rewards;
  JsonList seeds;
  for (const Kept& kept : kept_) {
    lengths.emplace_back(kept.length);
    successes.emplace_back(kept.success);
    rewards.emplace_back(kept.reward_sum);
    seeds.emplace_back(kept.seed);
  }
  JsonTable made_how = provenance(entry_, plan_);
  made_how.emplace_back("attempts", attempts());
  for (auto& [key, value] : addition_documents(entry_, plan_)) {
    if (value != Json()) made_how.emplace_back(key, std::move(value));
  }
  JsonTable document{{"env_id", entry_.id},
                     {"num_episodes", episodes()},
                     {"episode_lengths", lengths},
                     {"success_once", successes},
                     {"reward_sums", rewards},
                     {"episode_seeds", seeds},
                     {"batched_source_dir", nullptr},  // there never is one
                     {"unbatched_dir", "data_npz/" + std::string(entry_.id)},
                     {"engram", std::move(made_how)}};
  add_checksum(document);
  return document;
}

}  // namespace engram
