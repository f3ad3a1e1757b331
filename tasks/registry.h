// The registered tasks: from an id to what it means to a benchmark, and to a task that can be run.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "tasks/family.h"

namespace engram {

struct RegistryEntry {
  std::string_view id;      // "RememberColor9-VLA-v0"
  std::string_view family;  // "RememberColor"
  int horizon = 0;          // control steps
  Split split = Split::kShort;
  std::string_view memory_type;  // "Object"
  bool canonical = false;        // one of the 90 tasks of the benchmark proper
  std::string_view instruction;  // in English; "{angle_deg}" stands for a number of the episode
  double oracle_floor = 0;       // least share of episodes that the oracle solves
  const Family* definition = nullptr;
};

// All tasks, in the benchmark's order.
std::span<const RegistryEntry> registry() noexcept;

// The task of that exact id, or nullptr.
const RegistryEntry* find_entry(std::string_view id) noexcept;

// The same. Throws Error with the nearest id if there is none.
const RegistryEntry& require_entry(std::string_view id);

// The registered id with the fewest edits from `id`, upper and lower case being alike; the first of
// several. For suggestions in messages.
std::string nearest_id(std::string_view id);

// "short", "medium", "long" or "extended".
std::string_view split_name(Split split) noexcept;

// Throws Error with the nearest id if there is no such task.
std::unique_ptr<Task> make_task(std::string_view id);

}  // namespace engram
