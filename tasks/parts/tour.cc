#include "tasks/parts/tour.h"

#include <algorithm>
#include <span>

#include "core/base/real_functions.h"
#include "tasks/parts/poses.h"
#include "tasks/parts/tool_servo.h"

namespace engram::tasks {
namespace {

constexpr double kRowRadius = 0.6;  // m from the base's axis: makes angles lengths
constexpr double kPassed = 0.006;   // m: a tool that much beyond a stop has left it

double along_row(const Eigen::Vector3d& point) {
  return kRowRadius * real::atan2(point.y(), point.x() - kRobotBaseX);
}

}  // namespace

void Tour::add(const Eigen::Vector3d& stop) {
  const Stop added{stop, along_row(stop)};
  int place = size_++;
  for (; place > 0 && stops_[static_cast<std::size_t>(place) - 1].along > added.along; --place) {
    stops_[static_cast<std::size_t>(place)] = stops_[static_cast<std::size_t>(place) - 1];
  }
  stops_[static_cast<std::size_t>(place)] = added;
}

Tour::Move Tour::next(const State& state, int env, const Way& way) const {
  const Eigen::Vector3d tool = tcp_pos(state, env);
  const std::span stops = std::span(stops_).first(static_cast<std::size_t>(size_));
  if (tool.z() > way.start_height) {
    const auto away = [&tool](const Stop& stop) { return (stop.point - tool).head<2>().norm(); };
    const auto first = way.from_the_end ? stops.begin() : std::ranges::min_element(stops, {}, away);
    return {approach_from_above(state, env, first->point, way.travel_gap),
            static_cast<int>(first - stops.begin())};
  }
  const double along = along_row(tool);
  const bool still = robot_is_static(state, env);
  for (const Stop& stop : stops) {
    const bool last = &stop == &stops.back();
    if (along > stop.along + kPassed && !last) continue;
    const bool there = (tool - stop.point).norm() < way.reach;
    if (there && still && !last) continue;
    return {stop.point, static_cast<int>(&stop - stops.data()), there};
  }
  return {tool, size_ - 1, true};
}

}  // namespace engram::tasks
