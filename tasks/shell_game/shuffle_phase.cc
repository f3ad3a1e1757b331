#include "tasks/shell_game/shuffle_phase.h"

#include <array>
#include <string>

#include "core/base/error.h"

namespace engram::tasks {
namespace {

enum OwnDraw { kShuffleSteps, kNumSwaps, kSwapPairList };

constexpr Bounds kSwaps{1, ShufflePhase::kMaxSwaps};
constexpr int kStepsOfSwap = 2;   // so many show which mugs swap
constexpr int kTimeToTouch = 12;  // control steps

}  // namespace

void ShuffleParams::constants(Changes& list) {
  ShellGameParams::constants(list);
  list.steps("SHUFFLE_PHASE_STEPS", SHUFFLE_PHASE_STEPS, kPhaseSteps,
             "how long the whole shuffle takes");
  list.integer_range("NUM_SWAPS", NUM_SWAPS.low, NUM_SWAPS.high, kSwaps, "", "swaps in a shuffle");
  list.real("SWAP_ARC_HEIGHT", SWAP_ARC_HEIGHT, {0, 0.12}, "m",
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
  check_time(horizon,
             {{"CUE_PHASE_STEPS", CUE_PHASE_STEPS.high},
              {"SHUFFLE_PHASE_STEPS", SHUFFLE_PHASE_STEPS.high}},
             kTimeToTouch);
}

void ShufflePhase::describe(TaskInfo& info) {
  info.phases = {{"cue", "elapsed < cue_steps"},
                 {"shuffle", "cue_steps <= elapsed < cue_steps + shuffle_steps"},
                 {"manipulation", "elapsed >= cue_steps + shuffle_steps"}};
  info.random_variables.push_back(params_.SHUFFLE_PHASE_STEPS.draw(
      "shuffle_steps", "length of the shuffle phase", "SHUFFLE_PHASE_STEPS"));
  info.random_variables.push_back(
      params_.NUM_SWAPS.draw("num_swaps", "swaps in the shuffle", "NUM_SWAPS"));
  info.random_variables.back().unit.clear();
  info.random_variables.push_back(
      {"swap_pairs", params_.NUM_SWAPS.high, true, 0, 2, "",
       "slots of each swap: 0 left and center, 1 left and right, 2 center and right"});
  snap_back_option_ = info.options.size();
  info.options.push_back({"snap_back", 0, true, 0, 1, "",
                          "1: steps left over after the last swap show the mugs as before it", 1});
  info.constants.emplace_back("NUM_SWAPS", params_.NUM_SWAPS.constant());
  info.constants.emplace_back("SHUFFLE_PHASE_STEPS", params_.SHUFFLE_PHASE_STEPS.constant());
  info.constants.emplace_back("SWAP_ARC_HEIGHT", params_.SWAP_ARC_HEIGHT);
}

void ShufflePhase::bind(const Bindings& bindings) {
  state_ = bindings.state;
  const bool snap_back = bindings.options[snap_back_option_] != 0;
  swaps_.bind(*bindings.memory, params_.NUM_SWAPS.high, snap_back);
}

void ShufflePhase::reset(const Episode& episode, int begin) const {
  const int steps = params_.SHUFFLE_PHASE_STEPS.sample(episode, first_draw_ + kShuffleSteps);
  const int swaps = params_.NUM_SWAPS.sample(episode, first_draw_ + kNumSwaps);
  const int draw_of_pairs = first_draw_ + kSwapPairList;
  const double* pinned = episode.pinned(draw_of_pairs);
  RandomStream random = episode.stream(draw_of_pairs);
  std::array<int, kMaxSwaps> pairs{};
  for (int i = 0; i < params_.NUM_SWAPS.high; ++i) {
    pairs[static_cast<std::size_t>(i)] =
        pinned != nullptr ? static_cast<int>(pinned[i]) : random.integer(0, 2);
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
