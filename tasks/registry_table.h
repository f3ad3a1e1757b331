// The registered tasks: what their ids mean to a benchmark. What the tasks do is defined elsewhere.
#pragma once

#include <span>
#include <string>
#include <string_view>

namespace engram {

// By length of an episode: up to 200 control steps, up to 601, and more. The tasks outside the
// canonical benchmark are kExtended, whatever their length.
enum class Split { kShort, kMedium, kLong, kExtended };

struct RegistryEntry {
  std::string_view id;      // "RememberColor9-VLA-v0"
  std::string_view family;  // "RememberColor"
  int horizon;              // control steps
  Split split;
  std::string_view memory_type;  // "Object"
  bool canonical;                // one of the 90 tasks of the benchmark proper
  std::string_view instruction;  // in English; "{angle_deg}" stands for a number of the episode
};

// All tasks, in the benchmark's order.
std::span<const RegistryEntry> registry() noexcept;

// The task of that exact id, or nullptr.
const RegistryEntry* find_entry(std::string_view id) noexcept;

// The registered id with the fewest edits from `id`, upper and lower case being alike; the first of
// several. For suggestions in messages.
std::string nearest_id(std::string_view id);

// "short", "medium", "long" or "extended".
std::string_view split_name(Split split) noexcept;

}  // namespace engram
