// Functions for scripts of custom tasks, over arrays with a row per environment: the experts'
// servos and tours, grasps, guesses.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

#include "tasks/common/tcp_servo.h"
#include "tasks/common/tour.h"

namespace engram::tasks {

// Rows of the robot's state; null where a function does not need them.
struct RobotRows {
  const double* qvel = nullptr;           // (n, 9)
  const double* tcp_pos = nullptr;        // (n, 3)
  const double* tcp_quat = nullptr;       // (n, 4)
  const std::int32_t* elapsed = nullptr;  // (n)
};

// Actions (n, 7) of pd_ee_delta_pose towards poses: goals (n, 3), orientations (n, 4), grippers
// (n).
void servo_rows(int count, const RobotRows& robot, const double* goals, const double* orientations,
                const double* grippers, float* actions);
// Waypoints (n, 3).
void approach_rows(int count, const RobotRows& robot, const double* goals, double clearance,
                   double* out);
void descend_rows(int count, const RobotRows& robot, const double* goals, double travel_height,
                  double* out);
// Orientations (n, 4) tilted outwards for points (n, 3).
void tilt_rows(int count, const double* orientations, const double* points, const Tilt& tilt,
               double* out);
// Next goals (n, 3) and rests (n) of tours over stops (n, num_stops, 3). num_stops: 1 to
// Tour::kMaxStops.
void tour_rows(int count, const RobotRows& robot, const double* stops, int num_stops,
               const Tour::Options& options, double* goals, std::uint8_t* rests);
// Whether both fingers hold a prop; finger_force: (n, num_props, 2, 3) N.
void grasp_rows(int count, const RobotRows& robot, const double* finger_force, int num_props,
                int prop, double min_force, double max_angle, std::uint8_t* out);
// Numbers (n, width) in [0, 1) of blind policies' streams: the same ones in every step of an
// episode.
void guess_rows(int count, const std::uint64_t* keys, const std::uint64_t* episodes, int width,
                double* out);
// A function of core/math/real_functions.h of all numbers; y: of the functions of two. False if
// there is no such function.
bool apply_real_function(std::string_view name, std::size_t count, const double* x, const double* y,
                         double* out);

}  // namespace engram::tasks
