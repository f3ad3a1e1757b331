#include "core/contact/cone_solver.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "core/base/index.h"
#include "core/contact/cone_solver_blocks.h"
#include "core/contact/friction_cone.h"
#include "core/math/dense.h"

namespace engram {
namespace {

constexpr double kTiny = 1e-15;

// Share of its slope that a line search may leave: the next direction removes it.
constexpr double kSlopeShare = 0.01;

// Product with a symmetric matrix.
template <int kSize>
void multiply(const double* matrix, const double* vector, double* product) {
  for (int i = 0; i < kSize; i += 2) {
    Pair sum = vector[0] * pair_at(matrix + i);
    for (int j = 1; j < kSize; ++j) sum += vector[j] * pair_at(matrix + j * kSize + i);
    set_pair(product + i, sum);
  }
}

}  // namespace

ConeSolver::ConeSolver(int dofs, int contacts, int rows) {
  for (std::vector<double>* vector : {&acceleration_, &contact_force_, &mass_acceleration_,
                                      &gradient_, &direction_, &mass_direction_, &inverse_}) {
    vector->resize(at(dofs));
  }
  for (std::vector<double>* matrix : {&quadratic_hessian_, &hessian_}) {
    matrix->resize(at(dofs) * at(dofs));
  }
  for (std::vector<double>* vector : {&residual_, &smooth_residual_, &jacobian_direction_}) {
    vector->resize(at(rows));
  }
  states_.resize(at(contacts));
  line_search_contacts_.resize(at(contacts));
}

// --- cost, gradient and states at one point ---

void ConeSolver::multiply_mass(const double* vector, double* product) const {
  for (const ConeBody& body : bodies_) {
    const double* const from = vector + body.begin;
    if (body.width == kRobotWidth) {
      multiply<kRobotWidth>(body.mass, from, product + body.begin);
    } else {
      multiply<kPropWidth>(body.mass, from, product + body.begin);
    }
  }
}

void ConeSolver::multiply_jacobian(const double* vector, double* product) const {
  for (const ConeContact* contact : contacts_) {
    with_shape(*contact, [&](auto first, auto second, auto dim) {
      multiply_rows<first, second>(*contact, dim, rows_.jacobian, vector, product);
    });
  }
}

double ConeSolver::gauss_cost(const double* mass_times, const double* acceleration) const {
  Pair sum = {0, 0};
  for (int i = 0; i < size_; i += 2) {
    sum += (pair_at(mass_times + i) - pair_at(smooth_force_ + i)) *
           (pair_at(acceleration + i) - pair_at(smooth_ + i));
  }
  return 0.5 * (sum[0] + sum[1]);
}

double ConeSolver::contact_cost(const double* residual) const {
  double cost = 0;
  for (const ConeContact* contact : contacts_) {
    cost += cost_of(*contact, rows_.stiffness + contact->row, residual + contact->row);
  }
  return cost;
}

// Begins at the better of two guesses: the warm start and the smooth acceleration.
void ConeSolver::begin(const double* start) {
  const auto residual_at = [&](const double* acceleration, double* residual) {
    multiply_jacobian(acceleration, residual);
    for (const ConeContact* contact : contacts_) {
      for (int k = 0; k < contact->dim; ++k) {
        residual[contact->row + k] -= rows_.reference[contact->row + k];
      }
    }
  };
  residual_at(start, residual_.data());
  residual_at(smooth_, smooth_residual_.data());
  multiply_mass(start, mass_acceleration_.data());
  const double cost = contact_cost(residual_.data()) + gauss_cost(mass_acceleration_.data(), start);
  if (cost > contact_cost(smooth_residual_.data())) {
    residual_.swap(smooth_residual_);
    std::copy_n(smooth_, size_, acceleration_.begin());
    multiply_mass(smooth_, mass_acceleration_.data());
  } else {
    std::copy_n(start, size_, acceleration_.begin());
  }
}

// Updates forces and cone states. Returns the cost.
double ConeSolver::update() {
  double cost = gauss_[0] = gauss_cost(mass_acceleration_.data(), acceleration_.data());
  for (std::size_t i = 0; i < contacts_.size(); ++i) {
    const ConeContact& contact = *contacts_[i];
    const double* const residual = residual_.data() + contact.row;
    const double* const stiffness = rows_.stiffness + contact.row;
    double* const force = rows_.force + contact.row;
    ScaledResidual scaled;
    bool satisfied = false;
    bool quadratic = true;
    if (contact.dim == 1) {
      satisfied = residual[0] >= 0;
    } else {
      scaled = scale_residual(contact, residual);
      satisfied = is_satisfied(contact, scaled);
      quadratic = is_quadratic(contact, scaled);
    }
    ConeState state = ConeState::kCone;
    if (satisfied) {
      state = ConeState::kSatisfied;
      std::fill_n(force, contact.dim, 0.0);
    } else if (quadratic) {
      state = ConeState::kQuadratic;
      cost += quadratic_cost(contact, stiffness, residual);
      for (int k = 0; k < contact.dim; ++k) force[k] = -stiffness[k] * residual[k];
    } else {
      const double curvature = cone_curvature(contact, stiffness[0]);
      const double distance = scaled.normal - contact.mu * scaled.tangent;
      cost += 0.5 * curvature * distance * distance;
      force[0] = -curvature * distance * contact.mu;
      const double share = -force[0] / scaled.tangent;
      for (int k = 1; k < contact.dim; ++k) {
        force[k] = share * scaled.u[k] * contact.friction[at(k - 1)];
      }
    }
    if ((state == ConeState::kQuadratic) != (states_[i] == ConeState::kQuadratic)) {
      quadratic_changed_ = true;
    }
    states_[i] = state;
  }
  return cost;
}

void ConeSolver::find_gradient() {
  std::fill_n(contact_force_.begin(), size_, 0.0);
  for (std::size_t i = 0; i < contacts_.size(); ++i) {
    if (states_[i] == ConeState::kSatisfied) continue;
    with_shape(*contacts_[i], [&](auto first, auto second, auto dim) {
      add_force<first, second>(*contacts_[i], dim, rows_.jacobian, rows_.force,
                               contact_force_.data());
    });
  }
  for (int i = 0; i < size_; i += 2) {
    set_pair(&gradient_[at(i)], pair_at(&mass_acceleration_[at(i)]) - pair_at(smooth_force_ + i) -
                                    pair_at(&contact_force_[at(i)]));
  }
}

// --- Newton's direction ---

void ConeSolver::build_quadratic_hessian() {
  std::fill_n(quadratic_hessian_.begin(), size_ * size_, 0.0);
  for (const ConeBody& body : bodies_) {
    for (int i = 0; i < body.width; ++i) {
      std::copy_n(body.mass + i * body.width, body.width,
                  quadratic_hessian_.begin() + (body.begin + i) * size_ + body.begin);
    }
  }
  for (std::size_t i = 0; i < contacts_.size(); ++i) {
    if (states_[i] != ConeState::kQuadratic) continue;
    const ConeContact& contact = *contacts_[i];
    const double* const rows = rows_.jacobian + contact.row * kRowWidth;
    const double* const stiffness = rows_.stiffness + contact.row;
    with_shape(contact, [&](auto first, auto second, auto dim) {
      double weighted[kMaxConeRows * kRowWidth];
      for (int k = 0; k < dim; ++k) {
        for (int j = 0; j < first + second; j += 2) {
          const int where = k * kRowWidth + j;
          set_pair(weighted + where, stiffness[k] * pair_at(rows + where));
        }
      }
      add_squares<first, second>(contact, dim, rows, weighted, quadratic_hessian_.data(), size_);
    });
  }
  quadratic_changed_ = false;
}

void ConeSolver::add_cone(const ConeContact& contact) {
  double cone[kMaxConeRows * kMaxConeRows];
  cone_hessian(contact, rows_.stiffness[contact.row], residual_.data() + contact.row, cone);
  const double* const rows = rows_.jacobian + contact.row * kRowWidth;
  with_shape(contact, [&](auto first, auto second, auto dim) {
    double weighted[kMaxConeRows * kRowWidth];
    for (int k = 0; k < dim; ++k) {
      const double* const scale = cone + k * kMaxConeRows;
      for (int j = 0; j < first + second; j += 2) {
        Pair sum = scale[0] * pair_at(rows + j);
        for (int l = 1; l < dim; ++l) sum += scale[l] * pair_at(rows + l * kRowWidth + j);
        set_pair(weighted + k * kRowWidth + j, sum);
      }
    }
    add_squares<first, second>(contact, dim, rows, weighted, hessian_.data(), size_);
  });
}

// The quadratic part of the Hessian changes seldom and is kept between iterations.
void ConeSolver::find_direction() {
  if (quadratic_changed_) build_quadratic_hessian();
  std::copy_n(quadratic_hessian_.begin(), size_ * size_, hessian_.begin());
  for (std::size_t i = 0; i < contacts_.size(); ++i) {
    if (states_[i] == ConeState::kCone) add_cone(*contacts_[i]);
  }
  for (int i = 0; i < size_; ++i) direction_[at(i)] = -gradient_[at(i)];
  engram::factor(hessian_.data(), inverse_.data(), size_);
  engram::solve(hessian_.data(), inverse_.data(), direction_.data(), size_);
}

// --- exact line search ---

void ConeSolver::prepare_line_search() {
  multiply_mass(direction_.data(), mass_direction_.data());
  multiply_jacobian(direction_.data(), jacobian_direction_.data());
  gauss_[1] = dot(direction_.data(), mass_acceleration_.data(), size_) -
              dot(direction_.data(), smooth_force_, size_);
  gauss_[2] = 0.5 * dot(direction_.data(), mass_direction_.data(), size_);
  for (std::size_t i = 0; i < contacts_.size(); ++i) {
    const ConeContact& contact = *contacts_[i];
    const double* const from = residual_.data() + contact.row;
    const double* const change = jacobian_direction_.data() + contact.row;
    const double* const stiffness = rows_.stiffness + contact.row;
    LineSearchContact line{};
    line.dim = contact.dim;
    for (int k = 0; k < contact.dim; ++k) {
      line.quad[0] += 0.5 * stiffness[k] * from[k] * from[k];
      line.quad[1] += stiffness[k] * from[k] * change[k];
      line.quad[2] += 0.5 * stiffness[k] * change[k] * change[k];
    }
    line.u0 = from[0];
    line.v0 = change[0];
    if (contact.dim > 1) {
      line.mu = contact.mu;
      line.u0 *= contact.mu;
      line.v0 *= contact.mu;
      for (int k = 1; k < contact.dim; ++k) {
        const double u = from[k] * contact.friction[at(k - 1)];
        const double v = change[k] * contact.friction[at(k - 1)];
        line.uu += u * u;
        line.uv += u * v;
        line.vv += v * v;
      }
      line.curvature = cone_curvature(contact, stiffness[0]);
    }
    line_search_contacts_[i] = line;
  }
}

ConeSolver::LineSearchPoint ConeSolver::evaluate(double alpha) const {
  double quad[3] = {gauss_[0], gauss_[1], gauss_[2]};
  LineSearchPoint point{alpha, 0, 0, 0};
  for (std::size_t i = 0; i < contacts_.size(); ++i) {
    const LineSearchContact& line = line_search_contacts_[i];
    const double normal = line.u0 + alpha * line.v0;
    const double square = line.dim == 1 ? 0 : line.uu + alpha * (2 * line.uv + alpha * line.vv);
    const double tangent = square > 0 ? std::sqrt(square) : 0;
    if (tangent > 0 ? normal >= line.mu * tangent : normal >= 0) continue;
    if (tangent <= 0 || line.mu * normal + tangent <= 0) {
      for (int k = 0; k < 3; ++k) quad[k] += line.quad[k];
      continue;
    }
    const double over = 1 / tangent;
    const double slope = (line.uv + alpha * line.vv) * over;
    const double bend = (line.vv - slope * slope) * over;
    const double distance = normal - line.mu * tangent;
    const double change = line.v0 - line.mu * slope;
    point.cost += 0.5 * line.curvature * distance * distance;
    point.slope += line.curvature * distance * change;
    point.curvature += line.curvature * (change * change - distance * line.mu * bend);
  }
  point.cost += alpha * alpha * quad[2] + alpha * quad[1] + quad[0];
  point.slope += 2 * alpha * quad[2] + quad[1];
  point.curvature += 2 * quad[2];
  if (point.curvature <= 0) point.curvature = kTiny;
  return point;
}

// Returns the step size alpha: Newton's method on the derivative, safeguarded by bisection of a
// shrinking bracket.
double ConeSolver::line_search(double cost) {
  constexpr int kMaxPoints = 50;
  const double length = std::sqrt(dot(direction_.data(), direction_.data(), size_));
  if (length < kTiny) return 0;
  prepare_line_search();
  const double descent = dot(direction_.data(), gradient_.data(), size_);
  const double enough =
      std::max(0.01 * options_.tolerance * length * options_.scale, -kSlopeShare * descent);
  double low = 0;
  double high = -1;  // none yet
  double step = 1;
  LineSearchPoint point = evaluate(1);  // where Newton's own step ends
  for (int tried = 1; !(std::abs(point.slope) < enough); ++tried) {
    (point.slope < 0 ? low : high) = point.alpha;
    double next = point.alpha - point.slope / point.curvature;
    const bool slow = std::abs(next - point.alpha) > 0.5 * std::abs(step);
    if (high >= 0 && (slow || next <= low || next >= high)) next = 0.5 * (low + high);
    step = next - point.alpha;
    if (next == point.alpha || next == low || next == high) break;  // exact
    if (tried == kMaxPoints) return point.cost <= cost ? point.alpha : 0;
    point = evaluate(next);
  }
  return point.alpha;
}

// --- Newton's method ---

void ConeSolver::solve(std::span<const ConeBody> bodies,
                       std::span<const ConeContact* const> contacts, const ConeRows& rows,
                       const Options& options, const double* smooth_force, const double* smooth,
                       const double* start) {
  bodies_ = bodies;
  contacts_ = contacts;
  rows_ = rows;
  options_ = options;
  smooth_force_ = smooth_force;
  smooth_ = smooth;
  size_ = bodies.back().begin + bodies.back().width;
  begin(start);
  quadratic_changed_ = true;
  double cost = update();
  find_gradient();
  for (iterations_ = 0; iterations_ < options.iterations;) {
    find_direction();
    const double alpha = line_search(cost);
    if (alpha == 0) break;
    ++iterations_;
    add_scaled(acceleration_.data(), alpha, direction_.data(), size_);
    add_scaled(mass_acceleration_.data(), alpha, mass_direction_.data(), size_);
    for (const ConeContact* contact : contacts_) {
      for (int k = contact->row; k < contact->row + contact->dim; ++k) {
        residual_[at(k)] += alpha * jacobian_direction_[at(k)];
      }
    }
    const double before = cost;
    cost = update();
    find_gradient();
    const double gradient = std::sqrt(dot(gradient_.data(), gradient_.data(), size_));
    const double least = options.tolerance * options.scale;
    if (before - cost < least || gradient < least) break;
  }
}

}  // namespace engram
