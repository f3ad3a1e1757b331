// Everything that users can know of a task before they run it, as constants.
#pragma once

#include "protocol/batch/make.h"
#include "protocol/formats/document.h"

namespace engram {

// One table: registry, actions, draws, observation, outputs, constants, rewards, phases, props.
ConstantTable describe_task(const Batch& env);

// The part of it that lists show: registry, sizes in the canonical configuration, candidates. Needs
// no batch, so that a list of all tasks is quick.
ConstantTable describe_entry(const RegistryEntry& entry);

}  // namespace engram
