// Block kernels of the cone solver: products of a contact's Jacobian block with vectors and
// matrices, for block sizes that are compile-time constants.
#pragma once

#include <type_traits>

#include "core/contact/cone_problem.h"
#include "core/math/dense.h"

namespace engram {

// Calls visit with the widths of the contact's one or two bodies as constants, and the number of
// its rows, which is a constant if it is the usual one.
template <class Visit>
void with_shape(const ConeContact& contact, const Visit& visit) {
  using Robot = std::integral_constant<int, kRobotWidth>;
  using Prop = std::integral_constant<int, kPropWidth>;
  using None = std::integral_constant<int, 0>;
  const auto with_widths = [&](auto dim) {
    const bool pair = contact.width[1] != 0;
    if (contact.width[0] == kRobotWidth) {
      pair ? visit(Robot(), Prop(), dim) : visit(Robot(), None(), dim);
    } else {
      pair ? visit(Prop(), Prop(), dim) : visit(Prop(), None(), dim);
    }
  };
  constexpr int kUsual = 4;
  if (contact.dim == kUsual) {
    with_widths(std::integral_constant<int, kUsual>());
  } else {
    with_widths(contact.dim);
  }
}

// product[row] = Jacobian * vector
template <int kFirst, int kSecond, class Dim>
void multiply_rows(const ConeContact& contact, Dim dim, const double* jacobian,
                   const double* vector, double* product) {
  Pair local[(kFirst + kSecond) / 2];
  for (int i = 0; i < kFirst / 2; ++i) local[i] = pair_at(vector + contact.begin[0] + 2 * i);
  for (int i = 0; i < kSecond / 2; ++i) {
    local[kFirst / 2 + i] = pair_at(vector + contact.begin[1] + 2 * i);
  }
  for (int k = 0; k < dim; ++k) {
    const double* const row = jacobian + (contact.row + k) * kRowWidth;
    Pair sum = pair_at(row) * local[0];
    for (int i = 1; i < (kFirst + kSecond) / 2; ++i) sum += pair_at(row + 2 * i) * local[i];
    product[contact.row + k] = sum[0] + sum[1];
  }
}

// vector += Jacobian' * force
template <int kFirst, int kSecond, class Dim>
void add_force(const ConeContact& contact, Dim dim, const double* jacobian, const double* force,
               double* vector) {
  const double* const rows = jacobian + contact.row * kRowWidth;
  const double* const scale = force + contact.row;
  for (int i = 0; i < kFirst + kSecond; i += 2) {
    Pair sum = scale[0] * pair_at(rows + i);
    for (int k = 1; k < dim; ++k) sum += scale[k] * pair_at(rows + k * kRowWidth + i);
    add_pair(vector + (i < kFirst ? contact.begin[0] : contact.begin[1] - kFirst) + i, sum);
  }
}

// matrix += weighted' * rows, for kRows rows, on and right of the diagonal. Two rows of the matrix
// at a time.
template <int kRows, int kFirst, int kSecond>
void add_squares(const ConeContact& contact, const double* rows, const double* weighted,
                 double* matrix, int size) {
  constexpr int kWidth = kFirst + kSecond;
  const int first = contact.begin[0];
  const int second = contact.begin[1] - kFirst;
  for (int i = 0; i < kWidth; i += 2) {
    double* const above = matrix + ((i < kFirst ? first : second) + i) * size;
    double* const below = above + size;
    Pair scale[kRows];
    for (int k = 0; k < kRows; ++k) scale[k] = pair_at(weighted + k * kRowWidth + i);
    for (int j = i; j < kWidth; j += 2) {
      const int column = (j < kFirst ? first : second) + j;
      Pair sum_above = pair_at(above + column);
      Pair sum_below = pair_at(below + column);
      for (int k = 0; k < kRows; ++k) {
        const Pair row = pair_at(rows + k * kRowWidth + j);
        sum_above += scale[k][0] * row;
        sum_below += scale[k][1] * row;
      }
      set_pair(above + column, sum_above);
      set_pair(below + column, sum_below);
    }
  }
}

template <int kFirst, int kSecond, class Dim>
void add_squares(const ConeContact& contact, Dim dim, const double* rows, const double* weighted,
                 double* matrix, int size) {
  constexpr int kMany = 4;
  int k = 0;
  for (; k + kMany <= dim; k += kMany) {
    add_squares<kMany, kFirst, kSecond>(contact, rows + k * kRowWidth, weighted + k * kRowWidth,
                                        matrix, size);
  }
  for (; k < dim; ++k) {
    add_squares<1, kFirst, kSecond>(contact, rows + k * kRowWidth, weighted + k * kRowWidth, matrix,
                                    size);
  }
}

}  // namespace engram
