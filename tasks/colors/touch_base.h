// Base of the tasks of BunchOfColors, SeqOfColors and ChainOfColors: the sequence that an episode
// hides, the phases, the cubes, and the touches so far. The ids differ in what follows the touches.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <type_traits>

#include "tasks/colors/cubes.h"
#include "tasks/colors/params.h"
#include "tasks/colors/reward.h"
#include "tasks/common/family_base.h"
#include "tasks/common/phase_clock.h"
#include "tasks/common/reward_dict.h"
#include "tasks/common/touch_latch.h"

namespace engram::tasks {

class ColorTouchBase : public FamilyBase {
 public:
  int cue_end(int env) const final { return clock_.cue_end(env); }
  void sampled_values(int env, float* out) const final { write_sampled_values(*this, env, out); }
  template <class Visitor>
  void sampled_row(Visitor& row, int env) const {
    clock_.sampled_row(row, env);
  }
  void overlay(int env, Overlay& out) const final;

 protected:
  ColorTouchBase(const RegistryEntry& entry, const ColorRecallParams& params);

  void bind_touches(const Bindings& bindings);
  void bind_sequence(const Bindings& bindings);
  void bind_info(ColumnStore& info);

  // Draws the sequence, the cubes' places and the phases.
  void begin_episode(const Episode& episode) const;
  // One step of a phase. In the first `kept_steps` of the action phase cubes are put back.
  void show_phase(int env, int kept_steps) const;
  // One evaluation of the touches; gives the answer once it is known.
  TouchTally evaluate_touches(int env) const;
  // Publishes whether the robot is static, and returns it.
  bool note_static(int env) const;
  // Publishes the goal vector.
  void set_goal(int env, const Eigen::Vector3d& goal) const;

  std::span<const std::int32_t> sequence(int env) const {
    return {sequence_.row(env), at(params_.SEQUENCE_LENGTH)};
  }
  bool in_sequence(int env, int color) const;
  bool is_acting(int env) const {
    return clock_.phase(env, engine_.state->elapsed[env]) == Phase::kManipulation;
  }
  TouchTally count_touches(int env) const;
  ColorTouchReward touch_reward(int env) const;

  // The first fields of the state observation.
  template <class Visitor>
  void goal_fields(Visitor& row, int env) const {
    row.field("obj_to_goal_pos", 3, "m", "touch point of the next target minus TCP",
              [&] { return goal_.row(env); });
    row.field("oracle_info", params_.SEQUENCE_LENGTH, "", "colours of the cue, in its order",
              [&] { return sequence_.row(env); });
  }
  // The last ones. next_target: gives the colour to be touched next, -1: none.
  template <class Visitor, class Next>
  void cube_fields(Visitor& row, int env, const Next& next_target) const {
    int next = -1;
    if constexpr (std::is_same_v<Visitor, RowWriter>) next = next_target();
    for (int color = 0; color < params_.COLORS; ++color) {
      row.field(NumberedName{"cube_", color, "_pose"}, 3, "m", "position",
                [&] { return engine_.state->prop_pos_of(env, color); });
      row.field(NumberedName{"touched_", color, ""}, 1, "", "has been touched",
                [&] { return touch_.touched(env)[color]; });
      row.field(NumberedName{"cube_", color, "_in_seq"}, 1, "", "is one of the cue's",
                [&] { return in_sequence(env, color) ? 1 : 0; });
      row.field(NumberedName{"next_target_", color, ""}, 1, "", "is to be touched next",
                [&] { return color == next ? 1 : 0; });
    }
  }

  ColorRecallParams params_;
  ColorVariables variables_;
  ColorOptions options_;
  ColorRule rule_;  // by which touches are judged
  bool refuses_repeats_ = false;
  ColorCubes cubes_;
  PhaseClock clock_;
  TouchLatch touch_;
  RewardDict reward_dict_;
  Column<std::int32_t> sequence_;  // (SEQUENCE_LENGTH) colours of the cue
  Column<double> goal_;            // (3) m: obj_to_goal_pos in full precision
  Column<float> obj_to_goal_pos_;  // (3) m
  Column<std::uint8_t> is_robot_static_;

 private:
  void draw_sequence(const Episode& episode) const;
};

}  // namespace engram::tasks
