// Motion of the mugs in a shuffle: pairs swap slots along arcs, one pair after another.
#pragma once

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <span>

#include "core/base/column.h"
#include "tasks/shell_game/params.h"

namespace engram::tasks {

// The slots that swap s = 0, 1, 2 exchanges.
inline constexpr std::array<std::array<int, 2>, 3> kSwapPairs = {{{0, 1}, {0, 2}, {1, 2}}};

class Swaps {
 public:
  // Slots are `slot_distance` apart; mugs are lifted by up to `arc_height`. Both in metres.
  Swaps(double slot_distance, double arc_height)
      : slot_distance_(slot_distance), arc_height_(arc_height) {}

  // At most `max_swaps` swaps in an episode. `snap_back`: steps that are left over after the last
  // swap show the slots before it, not the final ones.
  void bind(ColumnStore& memory, int max_swaps, bool snap_back = false);

  // A shuffle of `steps` control steps that begins at elapsed = begin; each pair is an index into
  // kSwapPairs, and only the first `swaps` of them count.
  void reset(int env, int begin, int steps, int swaps, std::span<const int> pairs) const;

  int begin(int env) const { return begin_[env]; }
  int end(int env) const { return begin_[env] + steps_[env]; }
  bool is_running(int env, int elapsed) const {
    return elapsed >= begin(env) && elapsed < end(env);
  }

  // The slot of a mug, named after its first one, after `count` swaps; all of them if there were
  // fewer.
  int slot_of(int env, int swaps, int mug) const {
    return slots_.row(env)[3 * std::min(swaps, num_swaps_[env]) + mug];
  }
  int final_slot(int env, int mug) const { return slot_of(env, num_swaps_[env], mug); }

  // Offset of a mug while the shuffle runs, from where it would stand in the center slot.
  // The mugs of a pair turn about their midpoint, counter-clockwise seen from above; all three are
  // lifted.
  Eigen::Vector3d offset(int env, int mug, int elapsed) const;

 private:
  double slot_y(int slot) const { return (slot - 1) * slot_distance_; }

  double slot_distance_;  // m
  double arc_height_;     // m
  bool snap_back_ = false;
  Column<std::int32_t> begin_;  // control steps
  Column<std::int32_t> steps_;  // control steps
  Column<std::int32_t> num_swaps_;
  Column<std::uint8_t> slots_;  // ((max_swaps + 1) * 3): slot of each mug after 0, 1, ... swaps
};

}  // namespace engram::tasks
