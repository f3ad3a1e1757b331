// All fuzz targets by name, for the ordinary tests.
#pragma once

#include "tests/fuzz/input.h"

namespace engram::fuzz {

struct Target {
  const char* name;
  void (*run)(Data);
};

inline constexpr Target kTargets[] = {
    {"command_line", fuzz_command_line},
    {"c_api", fuzz_c_api},
    {"demonstrations", fuzz_demonstrations},
    {"edits", fuzz_edits},
    {"npz", fuzz_npz},
    {"policy_pipe", fuzz_policy_pipe},
    {"results", fuzz_results},
    {"snapshot", fuzz_snapshot},
};

}  // namespace engram::fuzz
