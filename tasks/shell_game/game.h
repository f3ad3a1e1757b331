// What the shell games share: three mugs upside down in a row, the slots they stand in, the cue and
// the info that all have (shell 1).
#pragma once

#include <Eigen/Dense>
#include <array>
#include <vector>

#include "core/task.h"
#include "mjcf/scene.h"
#include "tasks/parts/phase_clock.h"
#include "tasks/parts/reward_dict.h"
#include "tasks/registry_table.h"

namespace engram::tasks {

// Class constants that all shell games have (shell 0.2).
inline constexpr double BALL_RADIUS = 0.02;    // m
inline constexpr double MIN_DIST = 0.2;        // m, from slot to slot along y
inline constexpr double HEIGHT_OFFSET = 1000;  // m, added to the height of what is hidden
inline constexpr double MUG_SCALE = 1.3;

inline constexpr int kCups = 3;  // slots 0 left (-y), 1 center, 2 right

// How the mugs of a family stand: the model's handle, and the half turn that puts the rim down.
struct MugStance {
  double handle_yaw = 0;  // rad, in the mug's frame
  std::array<double, 4> quat{};
};
extern const MugStance kUpsideDown;
extern const MugStance kHandleTowardsRobot;  // ShellGamePick (README.md; shell 9, row 12)

class ShellGame : public Task {
 public:
  const TaskInfo& info() const override { return info_; }
  SceneSource scene() const override;
  std::string document() const override;
  void bind(const Bindings& bindings) override;
  void reset(const Episode& episode) override;
  int cue_end(int env) const override { return cue_steps_[env]; }
  void overlay(int env, Overlay& out) const override;

 protected:
  struct Setup {
    StepRange CUE_PHASE_STEPS{1, 5};
    double GOAL_THRESH = 0.08;  // m
    const char* target = "";    // name of the draw of the hidden cup or colour
    const char* target_description = "";
    bool frozen = true;  // the canonical wrapper zeroes actions before the manipulation phase
    double success_reward = 3;
    const MugStance* stance = &kUpsideDown;
  };
  // What every episode samples (shell 1.6); families go on from kFirstOwnDraw.
  enum DrawIndex { kTarget, kBase, kCueSteps, kFirstOwnDraw };

  ShellGame(const RegistryEntry& entry, const Setup& setup);

  // --- slots and phases ---

  Eigen::Vector3d base(int env) const { return {base_.row(env)[0], base_.row(env)[1], 0}; }
  // A point above a slot.
  Eigen::Vector3d slot_pos(int env, int slot, double height) const {
    return base(env) + Eigen::Vector3d(0, (slot - 1) * MIN_DIST, height);
  }
  Eigen::Vector3d mug_slot_pos(int env, int slot) const;  // of a mug that stands there
  bool is_cue(int env) const { return engine_.state->elapsed[env] < cue_steps_[env]; }
  bool is_manipulation(int env) const {
    return engine_.state->elapsed[env] >= manipulation_start_[env];
  }
  // True in the one step in which the robot is first meant to act.
  bool manipulation_begins(int env) const {
    return engine_.state->elapsed[env] == manipulation_start_[env];
  }
  void start_manipulation_at(int env, int elapsed) const;

  // --- mugs: props 0, 1, 2, named after the slots in which they start (shell 1.1) ---

  void hide_mug(int env, int mug, int slot) const;
  void stand_mug(int env, int mug, const Eigen::Vector3d& pos) const;
  void stand_mug(int env, int mug, int slot) const { stand_mug(env, mug, mug_slot_pos(env, slot)); }
  Eigen::Vector3d mug_pos(int env, int mug) const {
    return Eigen::Map<const Eigen::Vector3d>(engine_.state->prop_pos_of(env, mug));
  }

  // --- spheres: the red ball of a cup that hides one (shell 1.4), the goal region ---

  // These append a prop to the scene and return its index.
  int add_red_ball();
  int add_goal_site(double radius);  // people see it, sensors do not
  void place_sphere(int env, int sphere, const Eigen::Vector3d& pos) const;
  // One step of the mugs and the ball where physics moves the mugs: hidden while the ball shows in
  // its slot, then standing over it, then free, the ball going with its mug while that is low.
  void play_free_mugs(int env, int ball) const;

  // --- success and info (shell 1.8) ---

  struct Verdict {
    Eigen::Vector3d obj_to_goal;  // m
    bool placed = false;
    bool still = false;
    bool fair = true;  // the family's further conditions
  };
  // Success in the manipulation phase, and the info fields that all families have.
  void conclude(int env, const Verdict& verdict) const;
  Eigen::Vector3d obj_to_goal(int env) const {
    return Eigen::Map<const Eigen::Vector3d>(offset_.row(env));
  }
  double obj_to_goal_distance(int env) const { return obj_to_goal(env).norm(); }
  double arm_speed(int env) const;  // norm of the arm joint velocities, rad/s
  Eigen::Vector3d tcp_pos(int env) const {
    return Eigen::Map<const Eigen::Vector3d>(engine_.state->tcp_pos.row(env));
  }

  // The slot that the oracle goes for: the right one, or with `blind` a guess.
  int chosen_slot(int env, bool blind) const;

  // Write a point, or position and quaternion of a prop; return what follows.
  static float* write_point(const Eigen::Vector3d& point, float* out);
  float* write_pose(int env, int prop, float* out) const;

  TaskInfo info_;
  mjcf::Scene scene_;
  Setup setup_;
  Bindings engine_;
  RewardDict reward_dict_;
  Column<std::int32_t> target_;              // hidden cup or colour
  Column<std::int32_t> cue_steps_;           // control steps
  Column<std::int32_t> manipulation_start_;  // control steps
  Column<std::uint8_t> is_obj_placed_;
  Column<std::uint8_t> is_robot_static_;

 private:
  Column<double> base_;            // (2) m: the center slot
  Column<double> offset_;          // (3) m: obj_to_goal_pos in full precision
  Column<float> obj_to_goal_pos_;  // (3) m
};

// Phases of the families without a shuffle.
std::vector<std::pair<std::string, std::string>> cue_manipulation_phases();

}  // namespace engram::tasks
