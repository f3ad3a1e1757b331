// Contact forces among some bodies: the optimum of MuJoCo's convex problem over elliptic friction
// cones, by Newton's method with exact line search and MuJoCo's termination criteria.
#pragma once

#include <span>
#include <vector>

#include "core/contact/cone_problem.h"

namespace engram {

class ConeSolver {
 public:
  struct Options {
    double scale = 1;  // of cost and gradient
    double tolerance = 0;
    int iterations = 0;
  };

  // Allocates for the largest problem: velocities, contacts, rows.
  ConeSolver(int dofs, int contacts, int rows);

  // Solves one island: bodies, whose velocities follow one another, and all their contacts.
  // `smooth` and `smooth_force` are accelerations and forces without contacts; `start` is the warm
  // start. Writes the rows' forces, and:
  void solve(std::span<const ConeBody> bodies, std::span<const ConeContact* const> contacts,
             const ConeRows& rows, const Options& options, const double* smooth_force,
             const double* smooth, const double* start);
  const double* acceleration() const { return acceleration_.data(); }
  const double* contact_force() const { return contact_force_.data(); }  // on the bodies
  int iterations() const { return iterations_; }

 private:
  enum class ConeState { kSatisfied, kQuadratic, kCone };

  // Cost of a contact along the search direction.
  struct LineSearchContact {
    double quad[3];  // polynomial in alpha, if it sticks
    double u0, v0;   // normal
    double uu, uv, vv;
    double curvature;
    double mu;
    int dim;
  };
  struct LineSearchPoint {
    double alpha, cost, slope, curvature;
  };

  void multiply_mass(const double* vector, double* product) const;
  void multiply_jacobian(const double* vector, double* product) const;
  double gauss_cost(const double* mass_times, const double* acceleration) const;
  double contact_cost(const double* residual) const;
  void begin(const double* start);
  double update();
  void find_gradient();
  void build_quadratic_hessian();
  void find_direction();
  void add_cone(const ConeContact& contact);
  void prepare_line_search();
  LineSearchPoint evaluate(double alpha) const;
  double line_search(double cost);

  // --- present problem ---
  std::span<const ConeBody> bodies_;
  std::span<const ConeContact* const> contacts_;
  ConeRows rows_;
  Options options_;
  const double* smooth_force_ = nullptr;
  const double* smooth_ = nullptr;
  int size_ = 0;
  int iterations_ = 0;

  // --- per velocity ---
  std::vector<double> acceleration_;
  std::vector<double> contact_force_;
  std::vector<double> mass_acceleration_;
  std::vector<double> gradient_;
  std::vector<double> direction_;
  std::vector<double> mass_direction_;
  std::vector<double> quadratic_hessian_;  // mass, and contacts in the quadratic state
  std::vector<double> hessian_;            // also contacts in the cone state; then its factors
  std::vector<double> inverse_;            // inverse pivots

  // --- per row ---
  std::vector<double> residual_;         // acceleration minus reference
  std::vector<double> smooth_residual_;  // at the smooth acceleration; then spare
  std::vector<double> jacobian_direction_;

  // --- per contact ---
  std::vector<ConeState> states_;
  bool quadratic_changed_ = true;
  std::vector<LineSearchContact> line_search_contacts_;
  double gauss_[3] = {};
};

}  // namespace engram
