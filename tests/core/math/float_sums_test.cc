#include "core/math/float_sums.h"

#include <Eigen/Dense>
#include <bit>
#include <catch2/catch.hpp>
#include <cstdint>

namespace engram {
namespace {

std::uint32_t bits(float value) { return std::bit_cast<std::uint32_t>(value); }

// Numbers whose sum has other last bits in nearly any other order.
Eigen::VectorXf sample(int size, int seed) {
  Eigen::VectorXf v(size);
  for (int i = 0; i < size; ++i) {
    v[i] = static_cast<float>((seed * 7919 + i * 104729) % 1000) / 617.0F - 0.7F;
  }
  return v;
}

TEST_CASE("Lengths of floats have the bits that are written down", "[real]") {
  const float three[] = {0.1F, 0.7F, -0.3F};
  CHECK(bits(length_of_three(three)) == 0x3f44a328U);
  const Eigen::VectorXf seven = sample(7, 3);
  CHECK(bits(length_of(7, [&](int i) { return seven[i]; })) == 0x3f9c4720U);
}

// What engram has shown since its first version, which was compiled for these.
#ifdef EIGEN_VECTORIZE_SSE
TEST_CASE("Lengths of floats are those of Eigen with vectors of four", "[real]") {
  for (int seed = 0; seed < 200; ++seed) {
    for (int size = 0; size < 16; ++size) {
      const Eigen::VectorXf v = sample(size, seed);
      INFO(seed << " " << size);
      CHECK(bits(length_of(size, [&](int i) { return v[i]; })) == bits(v.norm()));
    }
    const Eigen::VectorXf v = sample(3, seed);
    CHECK(bits(length_of_three(v.data())) == bits(Eigen::Vector3f(v).norm()));
  }
}
#endif

}  // namespace
}  // namespace engram
