// Options that all suites share.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "core/batch/options.h"

namespace engram::bench {

struct SuiteOptions {
  std::vector<std::string> ids;     // empty: the suite's own choice
  int rounds = 20;                  // 1 or more
  Policy policy = Policy::kRandom;  // of the physics suite
  int threads = 0;                  // most threads of the scaling suite; 0: one per core
  int num_envs = 0;                 // 0: the suite's own choice
  int lanes = 0;                    // of the physics suite; see MakeOptions::lanes
  Physics physics = Physics::kEngram;
  std::function<void(double fraction)> progress;  // called between rounds; may be empty
};

}  // namespace engram::bench
