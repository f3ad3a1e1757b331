// The benchmark's own list of its tasks, mikasa_robo_vla_envs.csv, which scripts for the original
// read. Semicolons separate the columns, double quotes enclose the instruction.
#pragma once

#include <span>
#include <string>

#include "tasks/registry.h"

namespace engram {

// Columns id, Name, Max Length, Memory Type, Horizon Split, Data Source and language_instruction;
// one row per task of the canonical benchmark among the entries, in their order.
std::string benchmark_csv(std::span<const RegistryEntry* const> entries);

}  // namespace engram
