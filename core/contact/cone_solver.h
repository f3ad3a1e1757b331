// Forces of contacts among some bodies: the optimum of MuJoCo's convex problem, found by Newton's
// method, with MuJoCo's rules for when to stop.
#pragma once

#include <array>
#include <span>
#include <vector>

namespace engram {

// The bodies' velocities are one vector. Every part of it begins at an even place and has an even
// length; a number to spare is always zero.
struct ConeBody {
  const double* mass = nullptr;  // matrix of width x width
  int begin = 0;
  int width = 0;  // kRobotWidth or kPropWidth
};
constexpr int kRobotWidth = 10;
constexpr int kPropWidth = 6;
constexpr int kRowWidth = kRobotWidth + kPropWidth;

// A contact's rows are those of its directions: normal, two of friction, twist, two of rolling.
constexpr int kMostRows = 6;
struct ConeContact {
  int dim = 0;  // 1: without friction; otherwise 3, 4 or 6
  int row = 0;  // the first one
  // Of its one or two bodies. Rows of the Jacobian have the first one's columns, then the second's.
  std::array<int, 2> begin{};
  std::array<int, 2> width{};
  double mu = 0;  // of the cone in which normal and friction are equally soft
  std::array<double, kMostRows - 1> friction{};
};

// Of all rows.
struct ConeRows {
  const double* jacobian = nullptr;  // kRowWidth numbers per row
  const double* stiffness = nullptr;
  const double* reference = nullptr;  // acceleration, m/s^2
  double* force = nullptr;            // the result, N, N m
};

class ConeSolver {
 public:
  struct Rules {
    double scale = 1;  // of cost and gradient
    double tolerance = 0;
    int iterations = 0;
  };

  // Room for so many numbers of velocity, contacts, rows.
  ConeSolver(int numbers, int contacts, int rows);

  // One group of bodies, which begin one after the other, and all of its contacts. `smooth` and
  // `smooth_force` are what there is without contacts; `start` is a guess. Finds the rows' forces,
  // and:
  void solve(std::span<const ConeBody> bodies, std::span<const ConeContact* const> contacts,
             const ConeRows& rows, const Rules& rules, const double* smooth_force,
             const double* smooth, const double* start);
  const double* acceleration() const { return acceleration_.data(); }
  const double* contact_force() const { return contact_force_.data(); }  // on the bodies
  int iterations() const { return iterations_; }

 private:
  enum class Zone { kOpen, kSticking, kSliding };

  // A contact's cost along the line of a search.
  struct Course {
    double quad[3];  // polynomial in the way, if it sticks
    double u0, v0;   // normal
    double uu, uv, vv;
    double curvature;
    double mu;
    int dim;
  };
  struct Point {
    double way, cost, slope, curvature;
  };

  void multiply_mass(const double* vector, double* product) const;
  void multiply_jacobian(const double* vector, double* product) const;
  double gauss_cost(const double* mass_times, const double* acceleration) const;
  double contact_cost(const double* residual) const;
  void begin(const double* start);
  double update();
  void find_gradient();
  void build_base();
  void find_direction();
  void add_cone(const ConeContact& contact);
  void prepare_courses();
  Point evaluate(double way) const;
  double search(double cost);

  // --- of the present problem ---
  std::span<const ConeBody> bodies_;
  std::span<const ConeContact* const> contacts_;
  ConeRows rows_;
  Rules rules_;
  const double* smooth_force_ = nullptr;
  const double* smooth_ = nullptr;
  int size_ = 0;
  int iterations_ = 0;

  // --- numbers of velocity ---
  std::vector<double> acceleration_;
  std::vector<double> contact_force_;
  std::vector<double> mass_acceleration_;
  std::vector<double> gradient_;
  std::vector<double> direction_;
  std::vector<double> mass_direction_;
  std::vector<double> base_;     // matrix: mass, and what sticks
  std::vector<double> hessian_;  // with what slides, then its factors
  std::vector<double> inverse_;  // of its pivots

  // --- rows ---
  std::vector<double> residual_;  // acceleration less reference
  std::vector<double> other_;     // of the guess that was not taken
  std::vector<double> jacobian_direction_;

  // --- contacts ---
  std::vector<Zone> zone_;
  bool sticking_changed_ = true;
  std::vector<Course> courses_;
  double gauss_[3] = {};
};

}  // namespace engram
