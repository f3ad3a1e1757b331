// Cost of one contact over MuJoCo's elliptic friction cone: zero where the cone is satisfied,
// quadratic where the contact sticks, and the squared distance to the cone where it slides.
#pragma once

#include <cmath>
#include <cstddef>

#include "core/base/index.h"
#include "core/contact/cone_problem.h"

namespace engram {

// Residual of a contact, scaled so that its cone is circular: normal and tangential components.
struct ScaledResidual {
  double normal = 0;
  double tangent = 0;  // norm of u
  double u[kMaxConeRows] = {};
};

inline ScaledResidual scale_residual(const ConeContact& contact, const double* residual) {
  ScaledResidual scaled;
  scaled.normal = residual[0] * contact.mu;
  double square = 0;
  for (int k = 1; k < contact.dim; ++k) {
    scaled.u[k] = residual[k] * contact.friction[at(k - 1)];
    square += scaled.u[k] * scaled.u[k];
  }
  scaled.tangent = std::sqrt(square);
  return scaled;
}

inline bool is_satisfied(const ConeContact& contact, const ScaledResidual& scaled) {
  return scaled.normal >= contact.mu * scaled.tangent ||
         (scaled.tangent <= 0 && scaled.normal >= 0);
}
inline bool is_quadratic(const ConeContact& contact, const ScaledResidual& scaled) {
  return contact.mu * scaled.normal + scaled.tangent <= 0 ||
         (scaled.tangent <= 0 && scaled.normal < 0);
}

// Second derivative of the cost of a sliding contact along the distance to the cone.
inline double cone_curvature(const ConeContact& contact, double stiffness) {
  const double square = contact.mu * contact.mu;
  return stiffness / (square * (1 + square));
}

inline double quadratic_cost(const ConeContact& contact, const double* stiffness,
                             const double* residual) {
  double cost = 0;
  for (int k = 0; k < contact.dim; ++k) cost += 0.5 * stiffness[k] * residual[k] * residual[k];
  return cost;
}

inline double cost_of(const ConeContact& contact, const double* stiffness, const double* residual) {
  if (contact.dim == 1) {
    return residual[0] >= 0 ? 0 : 0.5 * stiffness[0] * residual[0] * residual[0];
  }
  const ScaledResidual scaled = scale_residual(contact, residual);
  if (is_satisfied(contact, scaled)) return 0;
  if (is_quadratic(contact, scaled)) return quadratic_cost(contact, stiffness, residual);
  const double distance = scaled.normal - contact.mu * scaled.tangent;
  return 0.5 * cone_curvature(contact, stiffness[0]) * distance * distance;
}

// Hessian of the cost of a sliding contact, kMaxConeRows numbers per row.
inline void cone_hessian(const ConeContact& contact, double stiffness, const double* residual,
                         double* hessian) {
  const ScaledResidual scaled = scale_residual(contact, residual);
  const double mu = contact.mu;
  const double over = 1 / scaled.tangent;
  const double steep = mu * scaled.normal * over;
  const double scale = cone_curvature(contact, stiffness);
  double along[kMaxConeRows];
  double slope[kMaxConeRows];
  for (int k = 1; k < contact.dim; ++k) {
    along[k] = scaled.u[k] * over;
    slope[k] = scale * contact.friction[at(k - 1)];
  }
  hessian[0] = scale * mu * mu;
  for (int k = 1; k < contact.dim; ++k) {
    const double mixed = -mu * mu * along[k] * slope[k];
    hessian[k] = hessian[k * kMaxConeRows] = mixed;
    for (int l = 1; l < contact.dim; ++l) {
      double value = steep * along[k] * along[l];
      if (k == l) value += mu * mu - steep;
      hessian[k * kMaxConeRows + l] = value * slope[k] * contact.friction[at(l - 1)];
    }
  }
}

}  // namespace engram
