// Everything that users can know of a task before they run it, as constants.
#pragma once

#include "protocol/io/json.h"
#include "protocol/make/make.h"

namespace engram {

// One table: registry, actions, draws, observation, outputs, constants, rewards, phases, props.
ConstantTable describe_task(const Batch& batch);

// Its parts, for descriptions of several tasks: fields of a row, one behind the other; with the
// ranges of their values; an output.
ConstantList describe_layout(const std::vector<Field>& fields);
ConstantList describe_layout(std::span<const RangedField> fields);
ConstantTable describe_output(const Field& field);

// The part of it that lists show: registry, sizes in the canonical configuration, candidates. Needs
// no batch, so that a list of all tasks is quick.
ConstantTable describe_entry(const RegistryEntry& entry);

}  // namespace engram
