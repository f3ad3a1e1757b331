#include "protocol/make/control_mode_choice.h"

#include <string>

#include "core/base/error.h"

namespace engram {

ControlMode common_control_mode(std::optional<ControlMode> given,
                                std::span<const RegistryEntry* const> tasks) {
  if (given) return *given;
  if (tasks.empty()) return RegistryEntry().control_mode;
  const RegistryEntry& first = *tasks.front();
  for (const RegistryEntry* other : tasks) {
    if (other->control_mode == first.control_mode) continue;
    throw Error(Error::kInvalidArgument,
                std::string("no control mode given, and ") + name_of(first.control_mode) +
                    " is that of " + std::string(first.id) + ", " + name_of(other->control_mode) +
                    " that of " + std::string(other->id) + "; one for all tasks needed");
  }
  return first.control_mode;
}

}  // namespace engram
