#include "core/batch/options.h"

#include <algorithm>
#include <initializer_list>
#include <limits>
#include <string>

#include "core/base/error.h"
#include "core/base/join.h"

namespace engram {
namespace {

constexpr double kNoLimit = std::numeric_limits<double>::infinity();

void require(bool good, const char* what, double given, const char* allowed) {
  if (good) return;
  throw Error(Error::kInvalidArgument,
              std::string(what) + ": " + shortest(given) + " given, " + allowed + " allowed");
}

void require(const char* what, double given, double low, double high, const char* allowed) {
  require(given >= low && given <= high, what, given, allowed);
}

void require(const char* what, double given, std::initializer_list<double> values,
             const char* allowed) {
  require(std::find(values.begin(), values.end(), given) != values.end(), what, given, allowed);
}

}  // namespace

void check_ranges(const BatchOptions& options) {
  // begin generated: ranges (tools/surface, from api/surface.toml)
  require("num_envs", options.num_envs, 1, 1'000'000, "1 to 1000000");
  require("threads", options.threads, 0, 1024, "0 (one per core) to 1024");
  require("chunk", options.chunk, 0, kNoLimit, "0 (chosen) or more");
  require("rotation_sign", options.rotation_sign, {-1, 1}, "-1 or 1");
  require("robot_init_qpos_noise", options.robot_init_qpos_noise, 0, 1, "0 to 1 rad");
  require("lanes", options.lanes, {0, 1, 4, 8, 16}, "0, 1, 4, 8 or 16");
  require("substeps", options.substeps, 0, 1000, "0 to 1000");
  // end generated
}

void check_ranges(const MakeOptions& options) {
  check_ranges(static_cast<const BatchOptions&>(options));
  // begin generated: task_ranges
  require("max_episode_steps", options.max_episode_steps, 0, 1'000'000, "0 (unset) to 1000000");
  // end generated
}

}  // namespace engram
