// Input of the cone solver: dynamic bodies, contacts and their constraint rows.
#pragma once

#include <array>

namespace engram {

// A dynamic body of the problem. The velocities of all bodies form one vector, in which every body
// begins at an even index and has an even width; padding is always zero.
struct ConeBody {
  const double* mass = nullptr;  // matrix of width x width
  int begin = 0;
  int width = 0;  // kRobotWidth or kPropWidth
};
constexpr int kRobotWidth = 10;
constexpr int kPropWidth = 6;
constexpr int kRowWidth = kRobotWidth + kPropWidth;

// A contact has a row per direction: normal, two tangents, torsional friction, two of rolling
// friction.
constexpr int kMaxConeRows = 6;
struct ConeContact {
  int dim = 0;  // 1: without friction; otherwise 3, 4 or 6
  int row = 0;  // index of the first row
  // Velocity ranges of its one or two bodies. A row of the Jacobian has the columns of the first
  // body, then those of the second.
  std::array<int, 2> begin{};
  std::array<int, 2> width{};
  double mu = 0;  // of the regularized cone (MuJoCo's mjContact::mu)
  std::array<double, kMaxConeRows - 1> friction{};
};

// Arrays of all rows.
struct ConeRows {
  const double* jacobian = nullptr;  // kRowWidth numbers per row
  const double* stiffness = nullptr;
  const double* reference = nullptr;  // acceleration, m/s^2
  double* force = nullptr;            // result, N, N m
};

}  // namespace engram
