// From the plain structs of the C door to the library's own, refusing what they cannot hold.
#pragma once

#include <cstdint>
#include <vector>

#include "engram/engram_c.h"
#include "protocol/batch/make.h"

namespace engram::c {

engram_options default_options() noexcept;

// Throws Error for anything that Batch could not be asked for; Batch checks the rest.
EnvOptions to_env_options(const engram_options& options);

Rules to_rules(std::int32_t rules);
std::vector<TaskOptionValue> to_choices(const engram_task_option* choices, std::size_t count);

std::vector<Pin> to_pins(const engram_pin* pins, std::size_t count);

Policy to_policy(std::int32_t policy);

}  // namespace engram::c
