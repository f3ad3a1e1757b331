// Base of the shell games: three mugs in a row, a cue that points out one of them, the phases, and
// the info that all have (docs/tasks/shell_game.md).
#pragma once

#include <Eigen/Dense>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/task/task.h"
#include "tasks/common/family_base.h"
#include "tasks/common/phase_clock.h"
#include "tasks/common/random_variables.h"
#include "tasks/common/reward_dict.h"
#include "tasks/registry.h"
#include "tasks/shell_game/mugs.h"

namespace engram::tasks {

class ShellGame : public FamilyBase {
 public:
  void bind(const Bindings& bindings) override;
  void reset(const Episode& episode) override;
  int cue_end(int env) const override { return cue_steps_[env]; }
  void sampled_values(int env, float* out) const override { write_sampled_values(*this, env, out); }
  template <class Visitor>
  void sampled_row(Visitor& row, int env) const {
    row.field("cue_steps_per_env", 1, "control steps", "length of the cue phase",
              [&] { return cue_steps_[env]; });
    if (!setup_.shuffles) return;
    row.field("empty_steps_per_env", 1, "control steps", "length of the shuffle",
              [&] { return manipulation_start_[env] - cue_steps_[env]; });
  }
  void overlay(int env, Overlay& out) const override;

  // --- queries of the parts of a game ---

  const Bindings& engine() const { return engine_; }
  const State& state() const { return *engine_.state; }
  const Mugs& mugs() const { return mugs_; }
  const RewardDict& reward_dict() const { return reward_dict_; }
  const ShellGameParams& params() const { return params_; }
  int target(int env) const { return target_[env]; }  // hidden cup or colour
  int answer(int env) const { return engine_.oracle_info[env]; }
  // True if the answer can be seen in the manipulation phase.
  bool is_answer_visible() const { return answer_visible_; }
  // The robot commits to a mug, named by its slot; -1: to none.
  void note_answer(int env, int slot) const {
    if (slot >= 0) engine_.answers.give(env, slot, slot == answer(env));
  }
  bool is_manipulation(int env) const {
    return engine_.state->elapsed[env] >= manipulation_start_[env];
  }
  Eigen::Vector3d tcp_pos(int env) const {
    return Eigen::Map<const Eigen::Vector3d>(engine_.state->tcp_pos.row(env));
  }
  Eigen::Vector3d obj_to_goal(int env) const {
    return Eigen::Map<const Eigen::Vector3d>(offset_.row(env));
  }
  // Fills in the inputs that the rewards of all games have.
  template <class RewardInputs>
  void fill_in(int env, RewardInputs& in) const {
    in.arm_speed = Eigen::Map<const ArmVector>(engine_.state->qvel.row(env)).norm();
    in.robot_static = is_robot_static_[env] != 0;
    in.placed = is_obj_placed_[env] != 0;
    in.manipulation = is_manipulation(env);
    in.success = engine_.success[env] != 0;
  }

  struct Outcome {
    Eigen::Vector3d obj_to_goal;  // m
    bool placed = false;
    bool still = false;
    bool extra_condition = true;  // the game's further conditions
  };

 protected:
  struct Setup {
    // Random variable of the hidden cup or colour.
    const char* target = "cup_with_ball_number";
    const char* target_description = "slot of the mug that hides the ball";
    // The canonical wrapper of VLA tasks zeroes actions before the manipulation phase.
    bool frozen = true;
    double success_reward = 3;
    std::span<const MugOrientation> orientations{&kUpsideDown, 1};
    bool shuffles = false;  // between cue and manipulation
  };
  ShellGame(const RegistryEntry& entry, const ShellGameParams& params, const Setup& setup);

  // --- phases ---

  // True in the one step in which the robot is first meant to act.
  bool manipulation_begins(int env) const {
    return engine_.state->elapsed[env] == manipulation_start_[env];
  }
  void start_manipulation_at(int env, int elapsed) const;

  // --- spheres: the red ball of a cup that hides one, the goal region ---

  // These append a prop to the scene and return its index.
  int add_red_ball();
  int add_goal_site(double radius);  // people see it, sensors do not
  void place_sphere(int env, int sphere, const Eigen::Vector3d& pos) const;
  // One step of the mugs and the ball where physics moves the mugs: hidden while the ball shows in
  // its slot, then standing over it, then free. The ball goes with its mug while that is low, or,
  // if it is `lifted_along`, wherever that goes.
  void update_free_mugs(int env, int ball, bool lifted_along = false) const;
  // Notes whether the mug over a ball keeps it from being seen.
  void cover_ball(int env, int ball, int mug) const;
  // Puts a ball inside its mug, and notes likewise.
  void carry_ball(int env, int ball, int mug) const;

  // --- success and info ---

  // Success, as far as the phase allows it, and the info fields that all games have.
  void set_outcome(int env, const Outcome& outcome) const;
  // Free mug that was moved or lifted farthest in the manipulation phase, if that is
  // farther than `least`, m; otherwise -1.
  int moved_mug(int env, double least) const;
  // To be called by bind(): memory is not needed.
  void reveal_answer();

  Mugs mugs_;
  Column<std::int32_t> target_;  // hidden cup or colour

 private:
  // Random variables of every episode; games add their own after these.
  struct Variables {
    Variables(RandomVariables list, const ShellGameParams& params, const Setup& setup);

    IntegerVariable target;
    VariableHandle base;
    IntegerVariable cue_steps;
  };

  ShellGameParams params_;
  Setup setup_;
  Variables variables_;
  RewardDict reward_dict_;
  Column<std::int32_t> cue_steps_;           // control steps
  Column<std::int32_t> manipulation_start_;  // control steps
  Column<double> offset_;                    // (3) m: obj_to_goal_pos in full precision
  Column<float> obj_to_goal_pos_;            // (3) m
  bool answer_visible_ = false;
  Column<std::uint8_t> is_obj_placed_;
  Column<std::uint8_t> is_robot_static_;
};

// Phases of the games without a shuffle.
std::vector<std::pair<std::string, std::string>> cue_manipulation_phases();

}  // namespace engram::tasks
