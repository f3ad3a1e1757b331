#include "tasks/registry.h"

#include <algorithm>
#include <array>
#include <cstddef>

#include "core/base/error.h"
#include "core/base/ieee_scope.h"
#include "core/base/nearest.h"
#include "core/env/task.h"
#include "tasks/variants.h"

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

// All tasks of all families, in a row.
class Table {
 public:
  Table() noexcept {
    for (const Family* family : kFamilies) {
      for (const TaskRow& row : family->tasks) add(*family, row);
    }
  }

  std::span<const RegistryEntry> entries() const { return {entries_.data(), count_}; }

 private:
  // Room without an allocation, which could fail where no error can be told.
  static constexpr std::size_t kMostTasks = 512;

  void add(const Family& family, const TaskRow& row) {
    entries_.at(count_) = {
        .id = row.id,
        .family = family.name,
        .horizon = row.horizon,
        .split = row.split,
        .memory_type = family.memory_type,
        .canonical = row.split != Split::kExtended,
        .instruction = row.instruction.empty() ? family.instruction : row.instruction,
        .oracle_floor = row.oracle_floor,
        .definition = &family,
        .base = row.id,
        .index = static_cast<int>(count_)};
    ++count_;
  }

  std::array<RegistryEntry, kMostTasks> entries_;
  std::size_t count_ = 0;
};

}  // namespace

std::span<const RegistryEntry> registry() noexcept {
  static const Table table;
  return table.entries();
}

const RegistryEntry* find_entry(std::string_view id) noexcept {
  const auto found = std::ranges::find(registry(), id, &RegistryEntry::id);
  return found == registry().end() ? find_variant_entry(id) : &*found;
}

const RegistryEntry& require_entry(std::string_view id) {
  if (const RegistryEntry* entry = find_entry(id)) return *entry;
  throw Error(Error::kUnknownId, "no task '" + std::string(id) + "'; did you mean '" +
                                     nearest_id(id) + "'? `engram list` shows all");
}

std::unique_ptr<Task> make_task(std::string_view id, const ConstantTable& constants,
                                int time_limit) {
  RegistryEntry entry = require_entry(id);
  entry.time_limit = time_limit;
  const IeeeScope scope;
  if (entry.constants == nullptr) return entry.definition->make(entry, constants);
  return entry.definition->make(entry, overridden(*entry.constants, constants));
}

std::string nearest_id(std::string_view id) {
  return nearest(all_entries(), id, [](const RegistryEntry* entry) { return entry->id; });
}

std::string_view split_name(Split split) noexcept {
  switch (split) {
    case Split::kShort:
      return "short";
    case Split::kMedium:
      return "medium";
    case Split::kLong:
      return "long";
    case Split::kExtended:
      return "extended";
  }
  return "";
}

}  // namespace engram
