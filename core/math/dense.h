// Small dense linear algebra. Every sum has a fixed order, two numbers side by side, so that every
// compiler gives the same bits, and all of them can use vectors. Rows have even
// lengths.
#pragma once

#include <cstring>

namespace engram {

using Pair = double __attribute__((vector_size(16)));

// Two numbers anywhere in memory. A reference would not do: Clang takes it to lie on 16 bytes.
inline Pair pair_at(const double* at) {
  Pair pair;
  std::memcpy(&pair, at, sizeof pair);
  return pair;
}
inline void set_pair(double* at, Pair pair) { std::memcpy(at, &pair, sizeof pair); }
inline void add_pair(double* at, Pair pair) { set_pair(at, pair_at(at) + pair); }

// to += scale * row
inline void add_scaled(double* to, double scale, const double* row, int count) {
  for (int i = 0; i < count; i += 2) add_pair(to + i, scale * pair_at(row + i));
}

inline double dot(const double* a, const double* b, int count) {
  Pair sum = {0, 0};
  for (int i = 0; i < count; i += 2) sum += pair_at(a + i) * pair_at(b + i);
  return sum[0] + sum[1];
}

// Factors a symmetric positive definite matrix, of whose rows only what is on and right of the
// diagonal counts: matrix = U' D U. Afterwards its rows hold D U, and `inverse` the inverse of D.
// Two pivots at a time.
inline void factor(double* matrix, double* inverse, int size) {
  constexpr double kMin = 1e-15;  // of a pivot
  for (int k = 0; k < size; k += 2) {
    double* const a = matrix + k * size;
    double* const b = a + size;
    inverse[k] = 1 / (a[k] > kMin ? a[k] : kMin);
    add_scaled(b + k, -(a[k + 1] * inverse[k]), a + k, size - k);
    inverse[k + 1] = 1 / (b[k + 1] > kMin ? b[k + 1] : kMin);
    for (int i = k + 2; i < size; ++i) {
      if (a[i] == 0 && b[i] == 0) continue;  // as between bodies that do not touch
      const double p = a[i] * inverse[k];
      const double q = b[i] * inverse[k + 1];
      double* const to = matrix + i * size;
      for (int j = i & ~1; j < size; j += 2) {
        set_pair(to + j, pair_at(to + j) - (p * pair_at(a + j) + q * pair_at(b + j)));
      }
    }
  }
}

// Overwrites x with the solution of matrix * solution = x, for a matrix that is factored.
inline void solve(const double* matrix, const double* inverse, double* x, int size) {
  for (int k = 0; k < size; k += 2) {
    const double* const a = matrix + k * size;
    const double* const b = a + size;
    const double p = x[k] * inverse[k];
    const double q = (x[k + 1] - p * a[k + 1]) * inverse[k + 1];
    for (int j = k + 2; j < size; j += 2) {
      set_pair(x + j, pair_at(x + j) - (p * pair_at(a + j) + q * pair_at(b + j)));
    }
    set_pair(x + k, Pair{p, q});
  }
  for (int k = size - 2; k >= 0; k -= 2) {
    const double* const a = matrix + k * size;
    const double* const b = a + size;
    Pair first = {0, 0};
    Pair second = {0, 0};
    for (int j = size - 2; j > k; j -= 2) {  // the latest comes last
      first += pair_at(a + j) * pair_at(x + j);
      second += pair_at(b + j) * pair_at(x + j);
    }
    const double q = x[k + 1] - inverse[k + 1] * (second[0] + second[1]);
    const double p = x[k] - inverse[k] * (first[0] + first[1] + a[k + 1] * q);
    set_pair(x + k, Pair{p, q});
  }
}

}  // namespace engram
