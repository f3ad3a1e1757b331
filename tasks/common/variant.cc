#include "tasks/common/variant.h"

#include <array>

#include "core/batch/options.h"

namespace engram::tasks {
namespace {

constexpr double kLongestEpisode = 1'000'000;  // control steps
constexpr std::array kRobots = {"panda_wristcam", "panda"};

}  // namespace

void declare_common(ConstantBinder& constants, RegistryEntry& entry) {
  int robot = 0;
  constants
      .name(kRobotConstant, robot, kRobots,
            "panda: the hand carries no camera; hand_camera is a point of view without a body")
      .published = false;
  entry.wrist_camera = robot == 0;
  constants
      .integer(kHorizonConstant, entry.horizon, {1, kLongestEpisode}, "control steps",
               "horizon: how long an episode may last")
      .published = false;
  double noise = BatchOptions().robot_init_qpos_noise;
  constants
      .real(kNoiseConstant, noise, {0, 1}, "rad",
            "standard deviation of the arm joints' noise in the start pose")
      .published = false;
}

}  // namespace engram::tasks
