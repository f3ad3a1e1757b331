// Tour of places for experts without memory: the next one follows from where the TCP is now.
#pragma once

#include <Eigen/Dense>
#include <array>

#include "core/sim/state.h"

namespace engram::tasks {

class Tour {
 public:
  static constexpr int kMaxStops = 16;

  // Stops are kept in the order of their angle about the robot's base.
  void add(const Eigen::Vector3d& stop);
  int size() const { return size_; }

  struct Options {
    double start_height = 0.13;  // m: a tool above that has not begun
    double reach = 0.025;        // m around a stop where the tool comes to rest
    // Where there is time, one tour after another from end to end, by the step count; otherwise a
    // single one that begins at the nearest stop.
    bool again = false;
    bool rests = true;  // false: to come within reach of a stop is enough
  };

  // Next goal of the TCP, or rest. It has rested at every stop that it leaves behind, or been
  // within reach of it; at the last one it stays.
  struct Target {
    Eigen::Vector3d goal;
    bool rest = false;  // brake, to be still
  };
  Target next(const State& state, int env, const Options& options) const;

 private:
  struct Stop {
    Eigen::Vector3d point;
    double along;  // m along the row
  };

  std::array<Stop, kMaxStops> stops_{};
  int size_ = 0;
};

}  // namespace engram::tasks
