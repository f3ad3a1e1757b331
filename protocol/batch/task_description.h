// Everything that users can know of a task before they run it, as constants.
#pragma once

#include "protocol/batch/make.h"
#include "protocol/formats/document.h"

namespace engram {

// What a list of tasks says of one: registry, sizes in the canonical configuration, candidates.
ConstantTable describe_entry(const RegistryEntry& entry);

// One table: registry, actions, draws, observation, outputs, constants, rewards, phases, props.
ConstantTable describe_task(const VectorEnv& env);

}  // namespace engram
