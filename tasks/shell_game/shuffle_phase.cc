#include "tasks/shell_game/shuffle_phase.h"

#include <array>

namespace engram::tasks {
namespace {

enum OwnDraw { kShuffleSteps, kNumSwaps, kSwapPairList };

}  // namespace

void ShufflePhase::describe(TaskInfo& info) {
  info.phases = {{"cue", "elapsed < cue_steps"},
                 {"shuffle", "cue_steps <= elapsed < cue_steps + shuffle_steps"},
                 {"manipulation", "elapsed >= cue_steps + shuffle_steps"}};
  const auto whole = [&info](const char* name, int width, StepRange range, const char* unit,
                             const char* what) {
    info.draws.push_back({name, width, true, static_cast<double>(range.low),
                          static_cast<double>(range.high), unit, what});
  };
  whole("shuffle_steps", 1, params_.SHUFFLE_PHASE_STEPS, "control steps",
        "length of the shuffle phase");
  whole("num_swaps", 1, params_.NUM_SWAPS, "", "swaps in the shuffle");
  whole("swap_pairs", params_.NUM_SWAPS.high, {0, 2}, "",
        "slots of each swap: 0 left and center, 1 left and right, 2 center and right");
  snap_back_option_ = info.options.size();
  info.options.push_back({"snap_back", 0, true, 0, 1, "",
                          "1: steps left over after the last swap show the mugs as before it", 1});
  info.constants.emplace_back("NUM_SWAPS", params_.NUM_SWAPS.constant());
  info.constants.emplace_back("SHUFFLE_PHASE_STEPS", params_.SHUFFLE_PHASE_STEPS.constant());
  info.constants.emplace_back("SWAP_ARC_HEIGHT", SWAP_ARC_HEIGHT);
}

void ShufflePhase::bind(const Bindings& bindings) {
  state_ = bindings.state;
  const bool snap_back = bindings.options[snap_back_option_] != 0;
  swaps_.bind(*bindings.memory, params_.NUM_SWAPS.high, snap_back);
}

void ShufflePhase::reset(const Episode& episode, int begin) const {
  const auto draw = [&](int index, StepRange range) {
    return episode.integer(first_draw_ + index, range.low, range.high);
  };
  const int steps = draw(kShuffleSteps, params_.SHUFFLE_PHASE_STEPS);
  const int swaps = draw(kNumSwaps, params_.NUM_SWAPS);
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
