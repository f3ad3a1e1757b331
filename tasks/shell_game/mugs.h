// Three mugs upside down in a row, and the slots they stand in.
#pragma once

#include <Eigen/Dense>
#include <array>
#include <span>
#include <vector>

#include "core/base/index.h"
#include "core/task/task.h"
#include "mjcf/scene.h"
#include "tasks/common/random_variables.h"
#include "tasks/shell_game/params.h"

namespace engram::tasks {

// Stance of the mugs of a game: the model's handle, and the half turn that puts the rim down.
struct MugOrientation {
  double handle_yaw = 0;  // rad, in the mug's frame
  std::array<double, 4> quat{};
  // Direction of the handle in the world, from that of kHandleTowardsRobot, rad.
  double handle_turn = 0;
};
extern const MugOrientation kUpsideDown;
extern const MugOrientation kHandleTowardsRobot;          // where ShellGamePick-VLA-v0 expects it
extern const std::array<MugOrientation, 3> kHandleTurns;  // one of which ShellGamePick-v0 draws

// Throws Error unless mugs that stand like that have so much room in between, m, and hide the balls
// under them.
void check_mugs(const ShellGameParams& params, const MugOrientation& orientation,
                double room = 0.001);

// Light comes under the rim of a mug that is lifted by more, m.
inline constexpr double kLiftThatShows = 0.004;

class Mugs {
 public:
  // Random variable of the place of the row.
  static VariableHandle declare_base(RandomVariables list);

  // Appends the mugs to the scene. They are its props 0, 1, 2, named after the slots in which they
  // start. `stances`: of which an episode has one; the scans are the same in all.
  Mugs(mjcf::Scene& scene, const ShellGameParams& params,
       std::span<const MugOrientation> orientations);

  void bind(const Bindings& bindings);
  // Draws the place of the row from its variable, and hides the mugs above it.
  void reset(const Episode& episode, const VariableHandle& base) const;
  // The stance of this episode, by index, where there are several; to be called after reset.
  void choose_orientation(int env, int index) const;
  // Direction of the handles, from that of kHandleTowardsRobot, rad.
  double handle_turn(int env) const { return orientation(env).handle_turn; }

  // The center slot, on the table.
  Eigen::Vector3d base(int env) const { return {base_.row(env)[0], base_.row(env)[1], 0}; }
  // A point above a slot.
  Eigen::Vector3d slot_pos(int env, int slot, double height) const {
    return base(env) + Eigen::Vector3d(0, (slot - 1) * slot_distance_, height);
  }
  // Height of the origin of a mug that stands, m.
  double resting_height() const { return resting_height_; }
  // Position of a mug that stands in a slot.
  Eigen::Vector3d standing_pos(int env, int slot) const;

  Eigen::Vector3d pos(int env, int mug) const {
    return Eigen::Map<const Eigen::Vector3d>(engine_.state->prop_pos_of(env, mug));
  }
  void stand(int env, int mug, const Eigen::Vector3d& pos) const;
  void stand(int env, int mug, int slot) const { stand(env, mug, standing_pos(env, slot)); }
  // Every mug in the slot in which it starts.
  void stand_all(int env) const;
  // True if a mug stands over what is beneath it, so that no camera sees that.
  bool hides(int env, int mug) const;
  // True if a mug is so upright that cameras, which look down, do not see into it.
  bool encloses(int env, int mug) const;
  // Position of a ball inside a mug, wherever that is: in the middle of its mouth, or on the wall
  // and on the foot of one that lies.
  Eigen::Vector3d pos_inside(int env, int mug, double radius) const;

 private:
  const MugOrientation& orientation(int env) const {
    return orientations_[orientations_.size() > 1 ? at(orientation_of_[env]) : 0];
  }
  // Height of the tip of a mug's axis, from foot to rim, as a unit vector: -1 upside down.
  double axis_height(int env, int mug) const;

  std::vector<MugOrientation> orientations_;
  double slot_distance_;   // m
  double resting_height_;  // m
  double hiding_radius_;   // m
  Bindings engine_;
  Column<double> base_;  // (2) m: the center slot
  Column<std::int32_t> orientation_of_;
};

}  // namespace engram::tasks
