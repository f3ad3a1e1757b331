// The control mode of a run over several tasks.
#pragma once

#include <optional>
#include <span>

#include "core/sim/control_mode.h"
#include "tasks/registry.h"

namespace engram {

// The given one, otherwise that of the tasks. Throws Error (kInvalidArgument) if theirs differ.
ControlMode common_control_mode(std::optional<ControlMode> given,
                                std::span<const RegistryEntry* const> tasks);

}  // namespace engram
