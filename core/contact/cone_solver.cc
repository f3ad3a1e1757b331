#include "core/contact/cone_solver.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "core/contact/contact_blocks.h"
#include "core/math/dense.h"

namespace engram {
namespace {

constexpr double kTiny = 1e-15;

// A search along a line may leave so much of its slope: the next direction sees to that.
constexpr double kShare = 0.01;

std::size_t at(int index) { return static_cast<std::size_t>(index); }

// Of a symmetric matrix.
template <int kSize>
void multiply(const double* matrix, const double* vector, double* product) {
  for (int i = 0; i < kSize; i += 2) {
    Pair sum = vector[0] * pair_at(matrix + i);
    for (int j = 1; j < kSize; ++j) sum += vector[j] * pair_at(matrix + j * kSize + i);
    set_pair(product + i, sum);
  }
}

// --- the friction cone ---

// A contact's residual, scaled so that its cone is round: normal and tangents.
struct Round {
  double normal = 0;
  double tangent = 0;  // length
  double u[kMostRows] = {};
};

Round round_residual(const ConeContact& contact, const double* residual) {
  Round round;
  round.normal = residual[0] * contact.mu;
  double square = 0;
  for (int k = 1; k < contact.dim; ++k) {
    round.u[k] = residual[k] * contact.friction[at(k - 1)];
    square += round.u[k] * round.u[k];
  }
  round.tangent = std::sqrt(square);
  return round;
}

bool is_open(const ConeContact& contact, const Round& round) {
  return round.normal >= contact.mu * round.tangent || (round.tangent <= 0 && round.normal >= 0);
}
bool is_sticking(const ConeContact& contact, const Round& round) {
  return contact.mu * round.normal + round.tangent <= 0 || (round.tangent <= 0 && round.normal < 0);
}

// Of the cost of what slides.
double sliding_curvature(const ConeContact& contact, double stiffness) {
  const double square = contact.mu * contact.mu;
  return stiffness / (square * (1 + square));
}

double sticking_cost(const ConeContact& contact, const double* stiffness, const double* residual) {
  double cost = 0;
  for (int k = 0; k < contact.dim; ++k) cost += 0.5 * stiffness[k] * residual[k] * residual[k];
  return cost;
}

double cost_of(const ConeContact& contact, const double* stiffness, const double* residual) {
  if (contact.dim == 1) {
    return residual[0] >= 0 ? 0 : 0.5 * stiffness[0] * residual[0] * residual[0];
  }
  const Round round = round_residual(contact, residual);
  if (is_open(contact, round)) return 0;
  if (is_sticking(contact, round)) return sticking_cost(contact, stiffness, residual);
  const double beyond = round.normal - contact.mu * round.tangent;
  return 0.5 * sliding_curvature(contact, stiffness[0]) * beyond * beyond;
}

// Second derivatives of the cost of what slides, kMostRows in a row.
void sliding_hessian(const ConeContact& contact, double stiffness, const double* residual,
                     double* hessian) {
  const Round round = round_residual(contact, residual);
  const double mu = contact.mu;
  const double over = 1 / round.tangent;
  const double steep = mu * round.normal * over;
  const double scale = sliding_curvature(contact, stiffness);
  double along[kMostRows];
  double slope[kMostRows];
  for (int k = 1; k < contact.dim; ++k) {
    along[k] = round.u[k] * over;
    slope[k] = scale * contact.friction[at(k - 1)];
  }
  hessian[0] = scale * mu * mu;
  for (int k = 1; k < contact.dim; ++k) {
    const double mixed = -mu * mu * along[k] * slope[k];
    hessian[k] = hessian[k * kMostRows] = mixed;
    for (int l = 1; l < contact.dim; ++l) {
      double value = steep * along[k] * along[l];
      if (k == l) value += mu * mu - steep;
      hessian[k * kMostRows + l] = value * slope[k] * contact.friction[at(l - 1)];
    }
  }
}

}  // namespace

ConeSolver::ConeSolver(int numbers, int contacts, int rows) {
  for (std::vector<double>* vector : {&acceleration_, &contact_force_, &mass_acceleration_,
                                      &gradient_, &direction_, &mass_direction_, &inverse_}) {
    vector->resize(at(numbers));
  }
  for (std::vector<double>* matrix : {&base_, &hessian_}) matrix->resize(at(numbers) * at(numbers));
  for (std::vector<double>* vector : {&residual_, &other_, &jacobian_direction_}) {
    vector->resize(at(rows));
  }
  zone_.resize(at(contacts));
  courses_.resize(at(contacts));
}

// --- the problem at one point ---

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

// Takes the better guess of two.
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
  residual_at(smooth_, other_.data());
  multiply_mass(start, mass_acceleration_.data());
  const double cost = contact_cost(residual_.data()) + gauss_cost(mass_acceleration_.data(), start);
  if (cost > contact_cost(other_.data())) {
    residual_.swap(other_);
    std::copy_n(smooth_, size_, acceleration_.begin());
    multiply_mass(smooth_, mass_acceleration_.data());
  } else {
    std::copy_n(start, size_, acceleration_.begin());
  }
}

// Forces, and on which side of its cone each contact is. Returns the cost.
double ConeSolver::update() {
  double cost = gauss_[0] = gauss_cost(mass_acceleration_.data(), acceleration_.data());
  for (std::size_t i = 0; i < contacts_.size(); ++i) {
    const ConeContact& contact = *contacts_[i];
    const double* const residual = residual_.data() + contact.row;
    const double* const stiffness = rows_.stiffness + contact.row;
    double* const force = rows_.force + contact.row;
    Round round;
    bool open = false;
    bool sticking = true;
    if (contact.dim == 1) {
      open = residual[0] >= 0;
    } else {
      round = round_residual(contact, residual);
      open = is_open(contact, round);
      sticking = is_sticking(contact, round);
    }
    Zone zone = Zone::kSliding;
    if (open) {
      zone = Zone::kOpen;
      std::fill_n(force, contact.dim, 0.0);
    } else if (sticking) {
      zone = Zone::kSticking;
      cost += sticking_cost(contact, stiffness, residual);
      for (int k = 0; k < contact.dim; ++k) force[k] = -stiffness[k] * residual[k];
    } else {
      const double curvature = sliding_curvature(contact, stiffness[0]);
      const double beyond = round.normal - contact.mu * round.tangent;
      cost += 0.5 * curvature * beyond * beyond;
      force[0] = -curvature * beyond * contact.mu;
      const double share = -force[0] / round.tangent;
      for (int k = 1; k < contact.dim; ++k) {
        force[k] = share * round.u[k] * contact.friction[at(k - 1)];
      }
    }
    if ((zone == Zone::kSticking) != (zone_[i] == Zone::kSticking)) sticking_changed_ = true;
    zone_[i] = zone;
  }
  return cost;
}

void ConeSolver::find_gradient() {
  std::fill_n(contact_force_.begin(), size_, 0.0);
  for (std::size_t i = 0; i < contacts_.size(); ++i) {
    if (zone_[i] == Zone::kOpen) continue;
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

void ConeSolver::build_base() {
  std::fill_n(base_.begin(), size_ * size_, 0.0);
  for (const ConeBody& body : bodies_) {
    for (int i = 0; i < body.width; ++i) {
      std::copy_n(body.mass + i * body.width, body.width,
                  base_.begin() + (body.begin + i) * size_ + body.begin);
    }
  }
  for (std::size_t i = 0; i < contacts_.size(); ++i) {
    if (zone_[i] != Zone::kSticking) continue;
    const ConeContact& contact = *contacts_[i];
    const double* const rows = rows_.jacobian + contact.row * kRowWidth;
    const double* const stiffness = rows_.stiffness + contact.row;
    with_shape(contact, [&](auto first, auto second, auto dim) {
      double weighted[kMostRows * kRowWidth];
      for (int k = 0; k < dim; ++k) {
        for (int j = 0; j < first + second; j += 2) {
          const int where = k * kRowWidth + j;
          set_pair(weighted + where, stiffness[k] * pair_at(rows + where));
        }
      }
      add_squares<first, second>(contact, dim, rows, weighted, base_.data(), size_);
    });
  }
  sticking_changed_ = false;
}

void ConeSolver::add_cone(const ConeContact& contact) {
  double cone[kMostRows * kMostRows];
  sliding_hessian(contact, rows_.stiffness[contact.row], residual_.data() + contact.row, cone);
  const double* const rows = rows_.jacobian + contact.row * kRowWidth;
  with_shape(contact, [&](auto first, auto second, auto dim) {
    double weighted[kMostRows * kRowWidth];
    for (int k = 0; k < dim; ++k) {
      const double* const scale = cone + k * kMostRows;
      for (int j = 0; j < first + second; j += 2) {
        Pair sum = scale[0] * pair_at(rows + j);
        for (int l = 1; l < dim; ++l) sum += scale[l] * pair_at(rows + l * kRowWidth + j);
        set_pair(weighted + k * kRowWidth + j, sum);
      }
    }
    add_squares<first, second>(contact, dim, rows, weighted, hessian_.data(), size_);
  });
}

// What sticks changes seldom, and its part is kept.
void ConeSolver::find_direction() {
  if (sticking_changed_) build_base();
  std::copy_n(base_.begin(), size_ * size_, hessian_.begin());
  for (std::size_t i = 0; i < contacts_.size(); ++i) {
    if (zone_[i] == Zone::kSliding) add_cone(*contacts_[i]);
  }
  for (int i = 0; i < size_; ++i) direction_[at(i)] = -gradient_[at(i)];
  engram::factor(hessian_.data(), inverse_.data(), size_);
  engram::solve(hessian_.data(), inverse_.data(), direction_.data(), size_);
}

// --- the search along a direction ---

void ConeSolver::prepare_courses() {
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
    Course course{};
    course.dim = contact.dim;
    for (int k = 0; k < contact.dim; ++k) {
      course.quad[0] += 0.5 * stiffness[k] * from[k] * from[k];
      course.quad[1] += stiffness[k] * from[k] * change[k];
      course.quad[2] += 0.5 * stiffness[k] * change[k] * change[k];
    }
    course.u0 = from[0];
    course.v0 = change[0];
    if (contact.dim > 1) {
      course.mu = contact.mu;
      course.u0 *= contact.mu;
      course.v0 *= contact.mu;
      for (int k = 1; k < contact.dim; ++k) {
        const double u = from[k] * contact.friction[at(k - 1)];
        const double v = change[k] * contact.friction[at(k - 1)];
        course.uu += u * u;
        course.uv += u * v;
        course.vv += v * v;
      }
      course.curvature = sliding_curvature(contact, stiffness[0]);
    }
    courses_[i] = course;
  }
}

ConeSolver::Point ConeSolver::evaluate(double way) const {
  double quad[3] = {gauss_[0], gauss_[1], gauss_[2]};
  Point point{way, 0, 0, 0};
  for (std::size_t i = 0; i < contacts_.size(); ++i) {
    const Course& course = courses_[i];
    const double normal = course.u0 + way * course.v0;
    const double square = course.dim == 1 ? 0 : course.uu + way * (2 * course.uv + way * course.vv);
    const double tangent = square > 0 ? std::sqrt(square) : 0;
    if (tangent > 0 ? normal >= course.mu * tangent : normal >= 0) continue;
    if (tangent <= 0 || course.mu * normal + tangent <= 0) {
      for (int k = 0; k < 3; ++k) quad[k] += course.quad[k];
      continue;
    }
    const double over = 1 / tangent;
    const double slope = (course.uv + way * course.vv) * over;
    const double bend = (course.vv - slope * slope) * over;
    const double beyond = normal - course.mu * tangent;
    const double change = course.v0 - course.mu * slope;
    point.cost += 0.5 * course.curvature * beyond * beyond;
    point.slope += course.curvature * beyond * change;
    point.curvature += course.curvature * (change * change - beyond * course.mu * bend);
  }
  point.cost += way * way * quad[2] + way * quad[1] + quad[0];
  point.slope += 2 * way * quad[2] + quad[1];
  point.curvature += 2 * quad[2];
  if (point.curvature <= 0) point.curvature = kTiny;
  return point;
}

// Returns how far to go along the direction: Newton's method within a bracket that shrinks.
double ConeSolver::search(double cost) {
  constexpr int kMost = 50;  // points
  const double length = std::sqrt(dot(direction_.data(), direction_.data(), size_));
  if (length < kTiny) return 0;
  prepare_courses();
  const double descent = dot(direction_.data(), gradient_.data(), size_);
  const double enough =
      std::max(0.01 * rules_.tolerance * length * rules_.scale, -kShare * descent);
  double low = 0;
  double high = -1;  // none yet
  double step = 1;
  Point point = evaluate(1);  // where Newton's own step ends
  for (int tried = 1; !(std::abs(point.slope) < enough); ++tried) {
    (point.slope < 0 ? low : high) = point.way;
    double next = point.way - point.slope / point.curvature;
    const bool slow = std::abs(next - point.way) > 0.5 * std::abs(step);
    if (high >= 0 && (slow || next <= low || next >= high)) next = 0.5 * (low + high);
    step = next - point.way;
    if (next == point.way || next == low || next == high) break;  // exact
    if (tried == kMost) return point.cost <= cost ? point.way : 0;
    point = evaluate(next);
  }
  return point.way;
}

// --- all of it ---

void ConeSolver::solve(std::span<const ConeBody> bodies,
                       std::span<const ConeContact* const> contacts, const ConeRows& rows,
                       const Rules& rules, const double* smooth_force, const double* smooth,
                       const double* start) {
  bodies_ = bodies;
  contacts_ = contacts;
  rows_ = rows;
  rules_ = rules;
  smooth_force_ = smooth_force;
  smooth_ = smooth;
  size_ = bodies.back().begin + bodies.back().width;
  begin(start);
  sticking_changed_ = true;
  double cost = update();
  find_gradient();
  for (iterations_ = 0; iterations_ < rules.iterations;) {
    find_direction();
    const double way = search(cost);
    if (way == 0) break;
    ++iterations_;
    add_scaled(acceleration_.data(), way, direction_.data(), size_);
    add_scaled(mass_acceleration_.data(), way, mass_direction_.data(), size_);
    for (const ConeContact* contact : contacts_) {
      for (int k = contact->row; k < contact->row + contact->dim; ++k) {
        residual_[at(k)] += way * jacobian_direction_[at(k)];
      }
    }
    const double before = cost;
    cost = update();
    find_gradient();
    const double gradient = std::sqrt(dot(gradient_.data(), gradient_.data(), size_));
    const double least = rules.tolerance * rules.scale;
    if (before - cost < least || gradient < least) break;
  }
}

}  // namespace engram
