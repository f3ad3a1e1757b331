#include "tasks/shell_game/shuffle_phase.h"

#include <array>
#include <string>

#include "core/base/error.h"
#include "core/base/index.h"
#include "tasks/common/phase_budget.h"

namespace engram::tasks {
namespace {

constexpr Bounds kSwaps{1, ShufflePhase::kMaxSwaps};
constexpr int kStepsOfSwap = 2;   // they show which mugs swap
constexpr int kTimeToTouch = 12;  // control steps

}  // namespace

void ShuffleParams::declare(ConstantBinder& constants) {
  ShellGameParams::declare(constants);
  constants.steps("SHUFFLE_PHASE_STEPS", SHUFFLE_PHASE_STEPS, kPhaseSteps,
                  "how long the whole shuffle takes",
                  {"shuffle_steps", "length of the shuffle phase"});
  constants.range("NUM_SWAPS", NUM_SWAPS, kSwaps, "", "swaps in a shuffle",
                  {"num_swaps", "swaps in the shuffle"});
  constants.real("SWAP_ARC_HEIGHT", SWAP_ARC_HEIGHT, {0, 0.12}, "m",
                 "how far cups are lifted while they swap");
}

void ShuffleParams::check(int horizon) const {
  check_touch();
  if (NUM_SWAPS.high * kStepsOfSwap > SHUFFLE_PHASE_STEPS.low) {
    throw Error(Error::kInvalidArgument,
                "constants leave no time to swap: NUM_SWAPS " + std::to_string(NUM_SWAPS.high) +
                    " x " + std::to_string(kStepsOfSwap) +
                    " control steps = " + std::to_string(NUM_SWAPS.high * kStepsOfSwap) +
                    ", more than SHUFFLE_PHASE_STEPS " + std::to_string(SHUFFLE_PHASE_STEPS.low));
  }
  check_horizon(horizon,
                {{"CUE_PHASE_STEPS", CUE_PHASE_STEPS.high},
                 {"SHUFFLE_PHASE_STEPS", SHUFFLE_PHASE_STEPS.high}},
                kTimeToTouch);
}

ShufflePhase::ShufflePhase(const ShuffleParams& params, RandomVariables list)
    : params_(params),
      steps_(list.of(params.SHUFFLE_PHASE_STEPS)),
      num_swaps_(list.of(params.NUM_SWAPS)),
      pairs_(list.add(
          {"swap_pairs", params.NUM_SWAPS.high, true, 0, 2, "",
           "slots of each swap: 0 left and center, 1 left and right, 2 center and right"})),
      swaps_(params.MIN_DIST, params.SWAP_ARC_HEIGHT) {}

void ShufflePhase::describe(TaskInfo& info) {
  info.phases = {{"cue", "elapsed < cue_steps"},
                 {"shuffle", "cue_steps <= elapsed < cue_steps + shuffle_steps"},
                 {"manipulation", "elapsed >= cue_steps + shuffle_steps"}};
  snap_back_ =
      TaskOptions(info.options)
          .on_off("snap_back", "1: steps left over after the last swap show the mugs as before it",
                  /*original=*/true);
}

void ShufflePhase::bind(const Bindings& bindings) {
  state_ = bindings.state;
  swaps_.bind(*bindings.memory, params_.NUM_SWAPS.high, snap_back_.is_on(bindings));
}

void ShufflePhase::reset(const Episode& episode, int begin) const {
  const int steps = steps_.sample(episode);
  const int swaps = num_swaps_.sample(episode);
  const double* pinned = pairs_.pinned(episode);
  RandomStream random = pairs_.stream(episode);
  std::array<int, kMaxSwaps> pairs{};
  for (int i = 0; i < params_.NUM_SWAPS.high; ++i) {
    pairs[at(i)] = pinned != nullptr ? static_cast<int>(pinned[i]) : random.integer(0, 2);
  }
  swaps_.reset(episode.env(), begin, steps, swaps, pairs);
}

void ShufflePhase::move(const Mugs& mugs, int env) const {
  const int elapsed = state_->elapsed[env];
  if (elapsed < swaps_.begin(env)) return;
  for (int mug = 0; mug < kCups; ++mug) {
    if (swaps_.is_running(env, elapsed)) {
      mugs.stand(env, mug, mugs.standing_pos(env, 1) + swaps_.offset(env, mug, elapsed));
    } else {
      mugs.stand(env, mug, swaps_.final_slot(env, mug));
    }
  }
}

}  // namespace engram::tasks
