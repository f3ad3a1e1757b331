// The batteries of a scene, their tray and their socket: where they belong, where they are, and the
// two teleports. Batteries are named by their slots.
#pragma once

#include "core/task/task.h"
#include "mjcf/scene.h"
#include "tasks/batteries_checker/params.h"
#include "tasks/batteries_checker/reward.h"
#include "tasks/common/layout.h"

namespace engram::tasks {

class BatteryRack {
 public:
  // Appends the props to a scene.
  BatteryRack(mjcf::Scene& scene, const BatteryParams& params);

  void bind(const Bindings& bindings);
  // A new episode: every battery in its slot.
  void reset(int env, const Vec2& tray) const;

  const BatteryParams& params() const { return params_; }
  int batteries() const { return params_.ACTIVE_BATTERY_COUNT; }
  int prop(int battery) const { return first_ + battery; }
  int tray_prop() const { return tray_; }
  int socket_prop() const { return socket_; }
  Vec2 tray(int env) const { return {tray_xy_.row(env)[0], tray_xy_.row(env)[1]}; }

  // Centre of a battery that stands in its slot; also of slots without one.
  Eigen::Vector3d slot(int env, int slot) const;
  // Origin of distances to the socket; in its hole, but 10.5 mm below the centre of a
  // battery that stands there.
  Eigen::Vector3d socket(int env) const;
  Eigen::Vector3d pos(int env, int battery) const;

  // Sets of batteries, as they are now.
  BatterySet grasped(int env) const;
  // In the socket's hole; whether they are held is another matter.
  BatterySet in_socket(int env) const;
  // Within `tolerance` times the tolerance of their own slots.
  BatterySet home(int env, double tolerance = 1) const;

  // Stands a battery upright in the middle of the socket, or as near to it as fingers that are
  // around it leave room for.
  void snap(int env, int battery) const;
  // Puts a battery back into its slot, or beside what stands there within the tolerance.
  void send_home(int env, int battery) const;

  static constexpr double kSocketRest = 0.0405;  // m: centre of a battery that stands in the socket

 private:
  double axis_distance(int env, int battery, const Vec2& point) const;
  bool is_free(int env, int battery, const Vec2& point) const;
  void teleport(int env, int battery, const Eigen::Vector3d& pos, bool clear) const;

  BatteryParams params_;
  int first_;  // index of the first battery's prop
  int tray_;
  int socket_;
  Bindings engine_;
  Column<double> tray_xy_;  // (2) m
};

}  // namespace engram::tasks
