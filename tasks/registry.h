// The registered tasks, the benchmark's own and those that users add: from an id to the facts that
// a benchmark needs, and to a task that can be run.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/constant.h"
#include "core/sim/control_mode.h"
#include "tasks/family.h"

namespace engram {

struct RegistryEntry {
  std::string_view id;      // "RememberColor9-VLA-v0"
  std::string_view family;  // "RememberColor"
  int horizon = 0;          // control steps
  Split split = Split::kShort;
  std::string_view memory_type;  // "Object"
  bool canonical = false;        // one of the 90 tasks of the VLA benchmark proper
  std::string_view instruction;  // in English; "{angle_deg}" stands for a number of the episode
  double oracle_floor = 0;       // least share of episodes that the oracle solves
  const Family* definition = nullptr;
  // A user's variant: the benchmark's task that it changes, and its constants. Otherwise its own
  // id, and null.
  std::string_view base;
  const ConstantTable* constants = nullptr;
  int index = 0;  // place among all_entries()
  // Control steps after which a user truncates episodes, even if that is too early to succeed; 0:
  // the horizon.
  int max_episode_steps = 0;
  bool wrist_camera = true;                                // false: the plain Panda
  ControlMode control_mode = ControlMode::kPdEeDeltaPose;  // of batches that are given none

  bool is_rl() const { return split == Split::kRl; }
};

// A new id for a task with other constants.
struct TaskVariant {
  std::string id;    // "RememberColor7-Slow-v0"
  std::string base;  // "RememberColor9-VLA-v0"; may be a variant itself
  ConstantTable constants = {};
  std::string instruction = {};  // "": that of the base

  friend bool operator==(const TaskVariant&, const TaskVariant&) = default;
};

// Registers all of them, or none, for the life of the process; may be called from any thread. A
// later one may build on an earlier one; the same variant twice is one. Throws Error: kUnknownId
// if there is no such base or constant, kInvalidArgument if an id is taken or not of the form
// name-vN, or the base's family refuses the constants.
void register_variants(std::span<const TaskVariant> variants);

// Adds the ids of families of a user's own, for the life of the process, or none of them; may be
// called from any thread. A family, and all that it points to, stays where it is. Ids that a
// family of the same name has brought before are this one's from now on. Throws Error
// (kInvalidArgument) if an id is not of the form name-vN, given twice, or another task's.
void register_families(std::span<const Family* const> families);
void register_family(const Family& family);

// The benchmark's tasks, in its order: the VLA tasks, then the RL tasks.
std::span<const RegistryEntry> registry() noexcept;

// These, then users' tasks and variants in the order in which they were registered. Entries stay
// where they are for the life of the process.
std::vector<const RegistryEntry*> all_entries();
const RegistryEntry& entry_at(int index);

// The variant behind an entry, its base being one of the benchmark's tasks.
TaskVariant variant_of(const RegistryEntry& entry);

// The task of that exact id, or nullptr.
const RegistryEntry* find_entry(std::string_view id) noexcept;

// The entry of an id. Throws Error with the nearest id if there is none.
const RegistryEntry& require_entry(std::string_view id);

// Constants in order, those of `others` instead of those of the same name.
ConstantTable merge_constants(const ConstantTable& constants, const ConstantTable& others);

// The registered id with the fewest edits from `id`, upper and lower case being alike; the first of
// several. For suggestions in messages.
std::string nearest_id(std::string_view id);

// constants: a user's values, by name. Throws Error with the nearest id if there is no such task,
// kUnknownId if it has no such constant, and kInvalidArgument if it cannot be made with these
// values. max_episode_steps: as in RegistryEntry.
std::unique_ptr<Task> make_task(std::string_view id, const ConstantTable& constants = {},
                                int max_episode_steps = 0);

}  // namespace engram
