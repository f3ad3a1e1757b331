#include "tasks/registry.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

#include "core/base/error.h"
#include "core/base/ieee_scope.h"
#include "core/task.h"

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
    entries_.at(count_++) = {
        .id = row.id,
        .family = family.name,
        .horizon = row.horizon,
        .split = row.split,
        .memory_type = family.memory_type,
        .canonical = row.split != Split::kExtended,
        .instruction = row.instruction.empty() ? family.instruction : row.instruction,
        .oracle_floor = row.oracle_floor,
        .definition = &family};
  }

  std::array<RegistryEntry, kMostTasks> entries_;
  std::size_t count_ = 0;
};

char to_lower(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

// Number of characters to insert, delete or replace to turn `a` into `b`, case being ignored.
std::size_t edit_distance(std::string_view a, std::string_view b) {
  // row[j]: distance between the part of `a` read so far and the first j characters of `b`.
  std::vector<std::size_t> row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i + 1;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t replaced = diagonal + (to_lower(a[i]) == to_lower(b[j]) ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({replaced, diagonal + 1, row[j] + 1});
    }
  }
  return row.back();
}

}  // namespace

std::span<const RegistryEntry> registry() noexcept {
  static const Table table;
  return table.entries();
}

const RegistryEntry* find_entry(std::string_view id) noexcept {
  const auto found = std::ranges::find(registry(), id, &RegistryEntry::id);
  return found == registry().end() ? nullptr : &*found;
}

const RegistryEntry& require_entry(std::string_view id) {
  if (const RegistryEntry* entry = find_entry(id)) return *entry;
  throw Error(Error::kUnknownId, "no task '" + std::string(id) + "'; did you mean '" +
                                     nearest_id(id) + "'? `engram list` shows all");
}

std::unique_ptr<Task> make_task(std::string_view id) {
  const IeeeScope scope;
  const RegistryEntry& entry = require_entry(id);
  return entry.definition->make(entry);
}

std::string nearest_id(std::string_view id) {
  // No id is nearly this long: what follows tells nothing and would only cost time.
  id = id.substr(0, 100);
  const auto distance = [id](const RegistryEntry& entry) { return edit_distance(id, entry.id); };
  return std::string(std::ranges::min_element(registry(), {}, distance)->id);
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
