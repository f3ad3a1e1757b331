// Everything that users can know of a task before they run it, as JSON.
#pragma once

#include "protocol/json.h"
#include "protocol/make.h"

namespace engram {

// What a list of tasks says of one: registry, sizes in the canonical configuration, candidates.
Json describe_entry(const RegistryEntry& entry);

// One object: registry, actions, draws, observation, outputs, constants, rewards, phases, props.
Json describe_task(const VectorEnv& env);

}  // namespace engram
