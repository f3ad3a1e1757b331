#include "core/math/dense.h"

#include <catch2/catch.hpp>
#include <vector>

#include "core/math/random.h"

namespace engram {
namespace {

// The sum of the squares of 1, ..., count, with the numbers some places into their memory.
double sum_of_squares(int count, int shift) {
  std::vector<double> numbers(static_cast<std::size_t>(count + shift));
  for (int i = 0; i < count; ++i) numbers[static_cast<std::size_t>(i + shift)] = i + 1;
  return dot(numbers.data() + shift, numbers.data() + shift, count);
}

// Memory is allocated on 16 bytes: a shift of one is off it.
TEST_CASE("Rows may begin at any number", "[physics][solver]") {
  for (const int count : {2, 10, 64}) {
    const double expected = count * (count + 1) * (2 * count + 1) / 6.0;
    CHECK(sum_of_squares(count, 0) == expected);
    CHECK(sum_of_squares(count, 1) == expected);
  }
}

TEST_CASE("What is factored solves, wherever it lies", "[physics][solver]") {
  constexpr int kSize = 10;
  const int shift = GENERATE(0, 1);
  RandomStream random(7, 0, 0);
  std::vector<double> memory(kSize * kSize + 1);
  double* const matrix = memory.data() + shift;
  for (int row = 0; row < kSize; ++row) {
    for (int column = row; column < kSize; ++column) {
      matrix[row * kSize + column] = random.uniform(-1, 1) + (row == column ? kSize : 0);
      matrix[column * kSize + row] = matrix[row * kSize + column];
    }
  }
  const std::vector<double> whole(matrix, matrix + kSize * kSize);
  std::vector<double> right(kSize);
  for (double& value : right) value = random.uniform(-1, 1);
  std::vector<double> solution(kSize + 1);
  double* const x = solution.data() + shift;
  for (int i = 0; i < kSize; ++i) x[i] = right[static_cast<std::size_t>(i)];
  std::vector<double> inverse(kSize);
  factor(matrix, inverse.data(), kSize);
  solve(matrix, inverse.data(), x, kSize);
  for (int row = 0; row < kSize; ++row) {
    CHECK(dot(whole.data() + row * kSize, x, kSize) ==
          Approx(right[static_cast<std::size_t>(row)]).margin(1e-12));
  }
}

}  // namespace
}  // namespace engram
