// Small dense linear algebra. Every sum has a fixed order, two numbers side by side, so that every
// compiler gives the same bits, and all of them can use vectors. Rows begin at even addresses and
// have even lengths.
#pragma once

namespace engram {

using Pair = double __attribute__((vector_size(16), aligned(8), may_alias));

inline const Pair& pair_at(const double* at) { return *reinterpret_cast<const Pair*>(at); }
inline Pair& pair_at(double* at) { return *reinterpret_cast<Pair*>(at); }

// to += scale * row
inline void add_scaled(double* to, double scale, const double* row, int count) {
  for (int i = 0; i < count; i += 2) pair_at(to + i) += scale * pair_at(row + i);
}

inline double dot(const double* a, const double* b, int count) {
  Pair sum = {0, 0};
  for (int i = 0; i < count; i += 2) sum += pair_at(a + i) * pair_at(b + i);
  return sum[0] + sum[1];
}

// Factors a symmetric positive definite matrix, of whose rows only what is on and right of the
// diagonal counts: matrix = U' D U. Afterwards its rows hold D U, and `inverse` the inverse of D.
inline void factor(double* matrix, double* inverse, int size) {
  constexpr double kLeast = 1e-15;  // of a pivot
  for (int k = 0; k < size; ++k) {
    const double* const row = matrix + k * size;
    inverse[k] = 1 / (row[k] > kLeast ? row[k] : kLeast);
    for (int i = k + 1; i < size; ++i) {
      if (row[i] == 0) continue;  // as between bodies that do not touch
      const int begin = i & ~1;
      add_scaled(matrix + i * size + begin, -(row[i] * inverse[k]), row + begin, size - begin);
    }
  }
}

// Overwrites x with the solution of matrix * solution = x, for a matrix that is factored.
inline void solve(const double* matrix, const double* inverse, double* x, int size) {
  for (int k = 0; k < size; ++k) {
    const double value = x[k] * inverse[k];
    const int begin = (k + 1) & ~1;
    add_scaled(x + begin, -value, matrix + k * size + begin, size - begin);
    x[k] = value;
  }
  for (int k = size - 1; k >= 0; --k) {
    const double value = x[k];
    const int begin = (k + 1) & ~1;
    x[k] = 0;
    x[k] = value - inverse[k] * dot(matrix + k * size + begin, x + begin, size - begin);
  }
}

}  // namespace engram
