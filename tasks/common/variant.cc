#include "tasks/common/variant.h"

#include "core/env/options.h"

namespace engram::tasks {
namespace {

constexpr double kLongestEpisode = 1'000'000;  // control steps

}  // namespace

void list_common_constants(Changes& list, RegistryEntry& entry) {
  list.integer(kHorizonConstant, entry.horizon, {1, kLongestEpisode}, "control steps",
               "horizon: how long an episode may last");
  double noise = BatchOptions().robot_init_qpos_noise;
  list.real(kNoiseConstant, noise, {0, 1}, "rad",
            "standard deviation of the arm joints' noise in the start pose");
}

}  // namespace engram::tasks
