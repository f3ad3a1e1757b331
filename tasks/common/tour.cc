#include "tasks/common/tour.h"

#include "core/base/index.h"
#include "core/math/real_functions.h"
#include "tasks/common/poses.h"
#include "tasks/common/tcp_servo.h"

namespace engram::tasks {
namespace {

constexpr double kRowRadius = 0.6;  // m from the base's axis: makes angles lengths
constexpr int kStepsPerStop = 12;   // control steps that a repeated tour has for every stop
constexpr int kStepsToRise = 8;     // and for its beginning
constexpr double kAbove = 0.05;     // m above the height at which a tour begins
constexpr double kBefore = 0.012;   // m
constexpr double kFunnel = 0.012;   // m: the approach to the first stop
constexpr double kFunnelSlope = 2;
constexpr double kThrough = 0.01;    // m beyond a stop: the goal of a tool that need not rest there
constexpr double kHeadStart = 0.16;  // m: so far before the middle begins a tour without rests
constexpr double kPassed = 0.006;    // m: a tool that much beyond a stop has left it

double along_row(const Eigen::Vector3d& point) {
  return kRowRadius * real::atan2(point.y(), point.x() - kRobotBaseX);
}

// A point of the row so far beyond another, in the sense of growing angles.
Eigen::Vector3d beyond(const Eigen::Vector3d& point, double distance) {
  const Eigen::Vector2d outward(point.x() - kRobotBaseX, point.y());
  return point + distance * Eigen::Vector3d(-outward.y(), outward.x(), 0) / outward.norm();
}

// A point a little before another, so that the tool does not come down beyond it.
Eigen::Vector3d before(const Eigen::Vector3d& point, double sense) {
  return beyond(point, -sense * kBefore);
}

}  // namespace

void Tour::add(const Eigen::Vector3d& stop) {
  const Stop added{stop, along_row(stop)};
  int place = size_++;
  for (; place > 0 && stops_[at(place) - 1].along > added.along; --place) {
    stops_[at(place)] = stops_[at(place) - 1];
  }
  stops_[at(place)] = added;
}

Tour::Target Tour::next(const State& state, int env, const Options& options) const {
  const Eigen::Vector3d tool = tcp_pos(state, env);
  // Every other tour goes the other options.
  const int steps = kStepsToRise + kStepsPerStop * (size_ + 1);
  const double sense = options.again && state.elapsed[env] / steps % 2 != 0 ? -1 : 1;
  const auto stop_at = [&](int place) -> const Stop& {
    return stops_[at(sense > 0 ? place : size_ - 1 - place)];
  };
  if (options.again && state.elapsed[env] % steps < kStepsToRise) {
    return {{tool.x(), tool.y(), options.start_height + kAbove}};
  }
  if (tool.z() > options.start_height) {
    int first = 0;
    while (!options.rests && first < size_ - 1 && sense * stop_at(first).along < -kHeadStart) {
      ++first;
    }
    for (int place = 1; place < size_ && !options.again && options.rests; ++place) {
      const auto away = [&](int at) { return (stop_at(at).point - tool).head<2>().norm(); };
      if (away(place) < away(first)) first = place;
    }
    return {
        approach_by_funnel(state, env, before(stop_at(first).point, sense), kFunnel, kFunnelSlope)};
  }
  const double along = sense * along_row(tool);
  const bool still = robot_is_static(state, env);
  for (int place = 0; place < size_ - 1; ++place) {
    const Stop& stop = stop_at(place);
    if (along > sense * stop.along + kPassed) continue;
    const bool there = (tool - stop.point).norm() < options.reach;
    if (options.rests && (!there || !still)) return {stop.point, there};
    if (!options.rests && !there) return {beyond(stop.point, sense * kThrough)};
  }
  const Stop& last = stop_at(size_ - 1);
  return {last.point, (tool - last.point).norm() < options.reach};
}

}  // namespace engram::tasks
