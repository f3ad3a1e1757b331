#include "tasks/custom/array_functions.h"

#include <algorithm>
#include <array>

#include "core/math/random.h"
#include "core/math/real_functions.h"
#include "core/task/episode.h"

namespace engram::tasks {
namespace {

// The rows as the state that servos read; they write nothing there.
template <class T>
Column<T> column(const T* rows, int width) {
  return {const_cast<T*>(rows), width};
}

State state_of(const RobotRows& robot) {
  State state;
  state.qvel = column(robot.qvel, kRobotJoints);
  state.tcp_pos = column(robot.tcp_pos, 3);
  state.tcp_quat = column(robot.tcp_quat, 4);
  state.elapsed = column(robot.elapsed, 1);
  return state;
}

Eigen::Vector3d vector(const double* rows, int row) {
  return Eigen::Vector3d(rows + static_cast<std::ptrdiff_t>(3) * row);
}

Eigen::Quaterniond quaternion(const double* rows, int row) {
  const double* q = rows + static_cast<std::ptrdiff_t>(4) * row;
  return {q[0], q[1], q[2], q[3]};
}

void write(const Eigen::Vector3d& value, double* rows, int row) {
  std::copy_n(value.data(), 3, rows + static_cast<std::ptrdiff_t>(3) * row);
}

struct OneNumber {
  std::string_view name;
  double (*apply)(double);
};
constexpr std::array kOfOne = {OneNumber{"sin", real::sin},  OneNumber{"cos", real::cos},
                               OneNumber{"tan", real::tan},  OneNumber{"exp", real::exp},
                               OneNumber{"log", real::log},  OneNumber{"asin", real::asin},
                               OneNumber{"tanh", real::tanh}};

}  // namespace

void servo_rows(int count, const RobotRows& robot, const double* goals, const double* orientations,
                const double* grippers, float* actions) {
  const State state = state_of(robot);
  for (int i = 0; i < count; ++i) {
    servo_tcp(state, i, vector(goals, i), quaternion(orientations, i), grippers[i],
              actions + static_cast<std::ptrdiff_t>(7) * i);
  }
}

void approach_rows(int count, const RobotRows& robot, const double* goals, double clearance,
                   double* out) {
  const State state = state_of(robot);
  for (int i = 0; i < count; ++i) {
    write(approach_from_above(state, i, vector(goals, i), clearance), out, i);
  }
}

void descend_rows(int count, const RobotRows& robot, const double* goals, double travel_height,
                  double* out) {
  const State state = state_of(robot);
  for (int i = 0; i < count; ++i) {
    write(descend(state, i, vector(goals, i), travel_height), out, i);
  }
}

void tilt_rows(int count, const double* orientations, const double* points, const Tilt& tilt,
               double* out) {
  for (int i = 0; i < count; ++i) {
    const Eigen::Quaterniond tilted =
        tilt_outwards(quaternion(orientations, i), vector(points, i), tilt);
    double* to = out + static_cast<std::ptrdiff_t>(4) * i;
    to[0] = tilted.w();
    to[1] = tilted.x();
    to[2] = tilted.y();
    to[3] = tilted.z();
  }
}

void tour_rows(int count, const RobotRows& robot, const double* stops, int num_stops,
               const Tour::Options& options, double* goals, std::uint8_t* rests) {
  const State state = state_of(robot);
  for (int i = 0; i < count; ++i) {
    Tour tour;
    for (int stop = 0; stop < num_stops; ++stop) tour.add(vector(stops, i * num_stops + stop));
    const Tour::Target next = tour.next(state, i, options);
    write(next.goal, goals, i);
    rests[i] = next.rest ? 1 : 0;
  }
}

void grasp_rows(int count, const RobotRows& robot, const double* finger_force, int num_props,
                int prop, double min_force, double max_angle, std::uint8_t* out) {
  State state = state_of(robot);
  state.num_props = num_props;
  state.finger_force = column(finger_force, 6 * num_props);
  for (int i = 0; i < count; ++i) {
    out[i] = is_grasping(state, i, prop, min_force, max_angle) ? 1 : 0;
  }
}

void guess_rows(int count, const std::uint64_t* keys, const std::uint64_t* episodes, int width,
                double* out) {
  for (int i = 0; i < count; ++i) {
    RandomStream random(keys[i], episodes[i], kPurposeBlindGuess);
    for (int k = 0; k < width; ++k) *out++ = random.uniform();
  }
}

bool apply_real_function(std::string_view name, std::size_t count, const double* x, const double* y,
                         double* out) {
  for (const OneNumber& function : kOfOne) {
    if (function.name != name || y != nullptr) continue;
    std::transform(x, x + count, out, function.apply);
    return true;
  }
  if (y == nullptr) return false;
  if (name == "atan2") {
    std::transform(x, x + count, y, out, [](double a, double b) { return real::atan2(a, b); });
    return true;
  }
  if (name == "hypot") {
    std::transform(x, x + count, y, out, [](double a, double b) { return real::hypot(a, b); });
    return true;
  }
  return false;
}

}  // namespace engram::tasks
