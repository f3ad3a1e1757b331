#include "tasks/registry.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <mutex>
#include <utility>

#include "core/base/error.h"
#include "core/base/ieee_scope.h"
#include "core/base/nearest.h"
#include "core/task/task.h"
#include "core/threads/process_mutex.h"

// The families, in the benchmark's order. A new one is one line here and its own files.
#define ENGRAM_FAMILIES(FAMILY)           \
  FAMILY(kShellGameTouch)                 \
  FAMILY(kShellGamePush)                  \
  FAMILY(kShellGamePick)                  \
  FAMILY(kShellGameColorLampTouch)        \
  FAMILY(kShellGameShuffleTouch)          \
  FAMILY(kShellGameShuffleColorLampTouch) \
  FAMILY(kRememberColor)                  \
  FAMILY(kRememberShape)                  \
  FAMILY(kRememberShapeAndColor)          \
  FAMILY(kFindImposterColor)              \
  FAMILY(kFindImposterShape)              \
  FAMILY(kFindImposterShapeAndColor)      \
  FAMILY(kSeqOfColors)                    \
  FAMILY(kChainOfColors)                  \
  FAMILY(kBunchOfColors)                  \
  FAMILY(kIntercept)                      \
  FAMILY(kInterceptGrab)                  \
  FAMILY(kRotateLenient)                  \
  FAMILY(kRotateStrict)                   \
  FAMILY(kTraceShape)                     \
  FAMILY(kTraceShapeSeq)                  \
  FAMILY(kBatteriesCheckerEasy)           \
  FAMILY(kBatteriesCheckerHard)           \
  FAMILY(kTakeItBack)                     \
  FAMILY(kGatherAndRecall)                \
  FAMILY(kTimedTransfer)                  \
  FAMILY(kBlinkCountButtonPress)

namespace engram {
namespace tasks {

#define ENGRAM_DECLARE(family) extern const Family family;
ENGRAM_FAMILIES(ENGRAM_DECLARE)
#undef ENGRAM_DECLARE

}  // namespace tasks

namespace {

#define ENGRAM_LIST(family) &tasks::family,
constexpr const Family* kFamilies[] = {ENGRAM_FAMILIES(ENGRAM_LIST)};
#undef ENGRAM_LIST

constexpr std::size_t kLongestId = 100;

// A user's task or variant. It never moves: entries and texts are pointed to.
struct UserTask {
  RegistryEntry entry;
  TaskVariant variant = {};  // of a variant
};
using UserTasks = std::vector<std::unique_ptr<UserTask>>;

RegistryEntry entry_of(const Family& family, const TaskSpec& row) noexcept {
  return {
      .id = row.id,
      .family = family.name,
      .horizon = row.horizon,
      .split = row.split,
      .memory_type = row.memory_type.empty() ? family.memory_type : row.memory_type,
      .canonical = row.split != Split::kExtended && !row.is_rl(),
      .instruction = row.instruction.empty() ? family.instruction : row.instruction,
      .oracle_floor = row.oracle_floor,
      .definition = &family,
      .base = row.id,
      .control_mode = row.is_rl() ? ControlMode::kPdJointDeltaPos : ControlMode::kPdEeDeltaPose};
}

// All tasks: the benchmark's, which never change, then users' own.
class TaskRegistry {
 public:
  // Allocates nothing: an allocation could fail where no error can be reported.
  TaskRegistry() noexcept {
    add_tasks(false);
    add_tasks(true);
  }

  std::span<const RegistryEntry> benchmark() const noexcept { return {entries_.data(), count_}; }

  const RegistryEntry* find(std::string_view id) const noexcept {
    const auto found = std::ranges::find(benchmark(), id, &RegistryEntry::id);
    if (found != benchmark().end()) return &*found;
    const std::scoped_lock lock(process_mutex(ProcessLock::kVariants));
    const auto own = std::ranges::find(users_, id, [](const auto& one) { return one->entry.id; });
    return own == users_.end() ? nullptr : &(*own)->entry;
  }

  std::vector<const RegistryEntry*> all() const {
    std::vector<const RegistryEntry*> entries;
    for (const RegistryEntry& entry : benchmark()) entries.push_back(&entry);
    const std::scoped_lock lock(process_mutex(ProcessLock::kVariants));
    for (const auto& one : users_) entries.push_back(&one->entry);
    return entries;
  }

  const RegistryEntry& at(int index) const {
    const auto place = static_cast<std::size_t>(index);
    if (place < count_) return entries_[place];
    const std::scoped_lock lock(process_mutex(ProcessLock::kVariants));
    return users_.at(place - count_)->entry;
  }

  // All are in the list, those of a known id in its place, or an exception leaves it as it was.
  void append(UserTasks added) {
    const std::scoped_lock lock(process_mutex(ProcessLock::kVariants));
    users_.reserve(users_.size() + added.size());
    replaced_.reserve(replaced_.size() + added.size());
    for (std::unique_ptr<UserTask>& one : added) {
      const auto known = std::ranges::find(users_, one->entry.id,
                                           [](const auto& other) { return other->entry.id; });
      one->entry.index = static_cast<int>(count_) + static_cast<int>(known - users_.begin());
      if (known == users_.end()) {
        users_.push_back(std::move(one));
      } else {
        replaced_.push_back(std::exchange(*known, std::move(one)));
      }
    }
  }

 private:
  static constexpr std::size_t kMaxTasks = 512;

  void add_tasks(bool rl) {
    for (const Family* family : kFamilies) {
      for (const TaskSpec& row : family->tasks) {
        if (row.is_rl() == rl) add(*family, row);
      }
    }
  }

  void add(const Family& family, const TaskSpec& row) {
    entries_.at(count_) = entry_of(family, row);
    entries_.at(count_).index = static_cast<int>(count_);
    ++count_;
  }

  std::array<RegistryEntry, kMaxTasks> entries_;
  std::size_t count_ = 0;
  // Used under ProcessLock::kVariants. What was replaced stays, as pointers to it may exist.
  UserTasks users_;
  UserTasks replaced_;
};

// Never destroyed: batches of users' tasks may outlive all static objects.
TaskRegistry& task_registry() noexcept {
  alignas(TaskRegistry) static std::array<std::byte, sizeof(TaskRegistry)> memory;
  static auto* const tasks = ::new (memory.data()) TaskRegistry;
  return *tasks;
}

// True for name-vN, Gymnasium's form.
bool is_id(std::string_view id) {
  const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
  const auto is_part = [&](char c) {
    return is_digit(c) || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '-' ||
           c == '_' || c == '.';
  };
  const std::size_t version = id.rfind("-v");
  return version != std::string_view::npos && version > 0 && id.size() <= kLongestId &&
         id.size() > version + 2 && std::ranges::all_of(id, is_part) &&
         std::ranges::all_of(id.substr(version + 2), is_digit);
}

// Throws Error. what: the id belongs to.
void require_id(std::string_view id, std::string_view what) {
  if (is_id(id)) return;
  throw Error(
      Error::kInvalidArgument,
      "id of a " + std::string(what) + ": '" + std::string(id) +
          "' given, letters, digits and '-_.' that end in -v and a number allowed, at most " +
          std::to_string(kLongestId));
}

[[noreturn]] void refuse_taken(std::string_view id, const RegistryEntry& taken,
                               std::string_view other) {
  const bool own = std::ranges::find(registry(), id, &RegistryEntry::id) != registry().end();
  throw Error(
      Error::kInvalidArgument,
      "id '" + std::string(id) + "' is taken, by " +
          (own                          ? std::string("a task of the benchmark")
           : taken.constants != nullptr ? "a variant" + std::string(other)
                                        : "a task of the family " + std::string(taken.family)) +
          "; another id needed");
}

// Throws Error unless a family may bring this task. added: tasks that come with it.
void require_registrable(const TaskSpec& row, const Family& family, const UserTasks& added) {
  const std::string_view id = row.id;
  require_id(id, "task");
  if (family.make == nullptr) {
    throw Error(Error::kInvalidArgument,
                "task '" + std::string(id) + "': a family without `make` given, a function needed");
  }
  if (row.is_rl()) {
    throw Error(Error::kInvalidArgument, "split of '" + std::string(id) +
                                             "': rl given, which is the benchmark's own; short, "
                                             "medium, long or extended allowed");
  }
  if (row.horizon < 1) {
    throw Error(Error::kInvalidArgument, "horizon of '" + std::string(id) +
                                             "': " + std::to_string(row.horizon) +
                                             " given, 1 or more allowed");
  }
  if (std::ranges::find(added, id, [](const auto& one) { return one->entry.id; }) != added.end()) {
    throw Error(Error::kInvalidArgument,
                "id '" + std::string(id) + "' given twice; another id needed");
  }
  const RegistryEntry* taken = find_entry(id);
  if (taken == nullptr) return;
  const bool replaces = taken->definition->name == family.name && taken->constants == nullptr;
  const bool own = std::ranges::find(registry(), id, &RegistryEntry::id) == registry().end();
  if (!replaces || !own) refuse_taken(id, *taken, "");
}

// The variant on one of the benchmark's tasks.
TaskVariant flattened(TaskVariant variant, const RegistryEntry& base) {
  variant.base = base.base;
  if (base.constants != nullptr) {
    variant.constants = merge_constants(*base.constants, variant.constants);
  }
  if (variant.instruction.empty()) variant.instruction = base.instruction;
  return variant;
}

// Takes the values as the task has them: a whole number stays one where 7.0 was given. Leaves out
// those that cannot be changed.
void take_values(const TaskInfo& info, ConstantTable& constants) {
  const auto find = [&info](const std::string& name) {
    return std::ranges::find(info.constants, name, &TaskConstant::name);
  };
  std::erase_if(constants, [&](const auto& entry) { return !find(entry.first)->changeable(); });
  for (auto& [name, value] : constants) value = find(name)->value;
}

// Variants that are about to be registered, all of them or none.
class NewVariants {
 public:
  void add(const TaskVariant& variant) {
    const std::string& id = variant.id;
    require_id(id, "variant");
    const RegistryEntry& base = base_of(variant);
    TaskVariant own = flattened(variant, base);
    const std::unique_ptr<Task> task = base.definition->make(base, own.constants);
    take_values(task->info(), own.constants);
    if (is_registered(own)) return;
    list_.push_back(std::make_unique<UserTask>());
    UserTask& added = *list_.back();
    added.variant = std::move(own);
    added.entry = base;
    added.entry.id = added.variant.id;
    added.entry.horizon = task->info().horizon;
    added.entry.canonical = false;
    added.entry.instruction = added.variant.instruction;
    added.entry.constants = &added.variant.constants;
  }

  UserTasks take() { return std::move(list_); }

 private:
  const RegistryEntry& base_of(const TaskVariant& variant) const {
    const auto own =
        std::ranges::find(list_, variant.base, [](const auto& one) { return one->variant.id; });
    return own == list_.end() ? require_entry(variant.base) : (*own)->entry;
  }

  // True for the same variant. Throws Error if another has its id.
  bool is_registered(const TaskVariant& own) const {
    const auto added =
        std::ranges::find(list_, own.id, [](const auto& one) { return one->variant.id; });
    const RegistryEntry* taken = added == list_.end() ? find_entry(own.id) : &(*added)->entry;
    if (taken == nullptr) return false;
    if (taken->constants != nullptr && variant_of(*taken) == own) return true;
    refuse_taken(own.id, *taken, " that is defined in another way");
  }

  UserTasks list_;
};

// What an unknown id may mean. Ids of the RL half differ from those of the VLA half by "-VLA"
// alone, so that a name without a version may be either.
std::string suggestion(std::string_view id) {
  constexpr std::string_view kRlEnd = "-v0";
  constexpr std::size_t kMisspelt = 3;  // edits
  const std::string name(id);
  if (id.ends_with(".py")) return "it is a file; " + name + ":ID names a task of it";
  const std::string near = nearest_id(id);
  std::string meant = "did you mean ";
  if (near.ends_with(kRlEnd)) {
    const std::string vla = near.substr(0, near.size() - kRlEnd.size()) + "-VLA-v0";
    if (find_entry(vla) != nullptr) meant += "'" + vla + "' or ";
  }
  meant += "'" + near + "'? `engram list` shows all";
  if (edit_distance(id, near) <= kMisspelt) return meant;
  return meant + ", and a task of your own needs its file: FILE.py:" + name +
         ", --tasks FILE.py, or ENGRAM_TASKS=FILE.py";
}

}  // namespace

std::span<const RegistryEntry> registry() noexcept { return task_registry().benchmark(); }

std::vector<const RegistryEntry*> all_entries() { return task_registry().all(); }

const RegistryEntry& entry_at(int index) { return task_registry().at(index); }

const RegistryEntry* find_entry(std::string_view id) noexcept { return task_registry().find(id); }

const RegistryEntry& require_entry(std::string_view id) {
  if (const RegistryEntry* entry = find_entry(id)) return *entry;
  throw Error(Error::kUnknownId, "no task '" + std::string(id) + "'; " + suggestion(id));
}

void register_variants(std::span<const TaskVariant> variants) {
  // Held from the check that an id is free to its registration.
  const std::scoped_lock one_at_a_time(process_mutex(ProcessLock::kRegistering));
  const IeeeScope scope;
  NewVariants added;
  for (const TaskVariant& variant : variants) added.add(variant);
  task_registry().append(added.take());
}

void register_families(std::span<const Family* const> families) {
  const std::scoped_lock one_at_a_time(process_mutex(ProcessLock::kRegistering));
  UserTasks added;
  for (const Family* family : families) {
    for (const TaskSpec& row : family->tasks) {
      require_registrable(row, *family, added);
      added.push_back(std::make_unique<UserTask>(UserTask{entry_of(*family, row)}));
    }
  }
  task_registry().append(std::move(added));
}

void register_family(const Family& family) { register_families(std::array{&family}); }

TaskVariant variant_of(const RegistryEntry& entry) {
  if (entry.constants == nullptr) return {std::string(entry.id), std::string(entry.id), {}, {}};
  return {std::string(entry.id), std::string(entry.base), *entry.constants,
          std::string(entry.instruction)};
}

ConstantTable merge_constants(const ConstantTable& constants, const ConstantTable& others) {
  ConstantTable all = constants;
  for (const auto& [name, value] : others) {
    const auto found = std::ranges::find(all, name, [](const auto& one) { return one.first; });
    if (found == all.end()) {
      all.emplace_back(name, value);
    } else {
      found->second = value;
    }
  }
  return all;
}

std::unique_ptr<Task> make_task(std::string_view id, const ConstantTable& constants,
                                int max_episode_steps) {
  RegistryEntry entry = require_entry(id);
  entry.max_episode_steps = max_episode_steps;
  const IeeeScope scope;
  if (entry.constants == nullptr) return entry.definition->make(entry, constants);
  return entry.definition->make(entry, merge_constants(*entry.constants, constants));
}

std::string nearest_id(std::string_view id) {
  return nearest(all_entries(), id, [](const RegistryEntry* entry) { return entry->id; });
}

}  // namespace engram
