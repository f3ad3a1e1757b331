// Three mugs upside down in a row, and the slots they stand in.
#pragma once

#include <Eigen/Dense>
#include <array>

#include "core/task.h"
#include "mjcf/scene.h"

namespace engram::tasks {

inline constexpr double MIN_DIST = 0.2;        // m, from slot to slot along y
inline constexpr double HEIGHT_OFFSET = 1000;  // m, added to the height of what is hidden
inline constexpr double MUG_SCALE = 1.3;

inline constexpr int kCups = 3;  // slots 0 left (-y), 1 center, 2 right

// How the mugs of a game stand: the model's handle, and the half turn that puts the rim down.
struct MugStance {
  double handle_yaw = 0;  // rad, in the mug's frame
  std::array<double, 4> quat{};
};
extern const MugStance kUpsideDown;
extern const MugStance kHandleTowardsRobot;  // where ShellGamePick expects it

class Mugs {
 public:
  // The draw of where the row stands.
  static Draw base_draw();

  // Appends the mugs to the scene. They are its props 0, 1, 2, named after the slots in which they
  // start.
  Mugs(mjcf::Scene& scene, const MugStance& stance);

  void bind(const Bindings& bindings);
  // Draws where the row stands, `draw` being the index of that draw, and hides the mugs above it.
  void reset(const Episode& episode, int draw) const;

  // The center slot, on the table.
  Eigen::Vector3d base(int env) const { return {base_.row(env)[0], base_.row(env)[1], 0}; }
  // A point above a slot.
  Eigen::Vector3d slot_pos(int env, int slot, double height) const {
    return base(env) + Eigen::Vector3d(0, (slot - 1) * MIN_DIST, height);
  }
  // Of a mug that stands in a slot.
  Eigen::Vector3d standing_pos(int env, int slot) const;

  Eigen::Vector3d pos(int env, int mug) const {
    return Eigen::Map<const Eigen::Vector3d>(engine_.state->prop_pos_of(env, mug));
  }
  void stand(int env, int mug, const Eigen::Vector3d& pos) const;
  void stand(int env, int mug, int slot) const { stand(env, mug, standing_pos(env, slot)); }
  // Every mug in the slot in which it starts.
  void stand_all(int env) const;

 private:
  MugStance stance_;
  Bindings engine_;
  Column<double> base_;  // (2) m: the center slot
};

}  // namespace engram::tasks
