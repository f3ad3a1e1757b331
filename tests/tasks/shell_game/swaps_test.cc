#include "tasks/shell_game/swaps.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <vector>

#include "core/math/random.h"

namespace engram::tasks {
namespace {

constexpr double MIN_DIST = 0.2;          // m
constexpr double SWAP_ARC_HEIGHT = 0.06;  // m

struct Bench {
  ColumnStore memory{1};
  Swaps swaps{MIN_DIST, SWAP_ARC_HEIGHT};

  explicit Bench(int max_swaps) { swaps.bind(memory, max_swaps); }
};

TEST_CASE("The shuffle of the test vector", "[shell]") {
  Bench bench(4);
  const Swaps& shuffle = bench.swaps;
  const std::vector<int> pairs = {0, 2, 1, 0};
  shuffle.reset(0, 4, 23, 3, pairs);
  const int rows[4][3] = {{0, 1, 2}, {1, 0, 2}, {2, 0, 1}, {0, 2, 1}};
  for (int swaps = 0; swaps < 4; ++swaps) {
    for (int mug = 0; mug < 3; ++mug) CHECK(shuffle.slot_of(0, swaps, mug) == rows[swaps][mug]);
  }
  CHECK(shuffle.slot_of(0, 4, 1) == 2);  // the fourth pair does not count
  CHECK(shuffle.end(0) == 27);

  // x, y, z of the three mugs.
  const std::map<int, std::vector<double>> table = {
      {4, {0.05, -0.23, 0.05295, 0.05, -0.03, 0.05295, 0.05, 0.17, 0.05295}},
      {7, {0.14446, -0.16281, 0.10962, -0.04446, -0.09719, 0.10962, 0.05, 0.17, 0.10962}},
      {11, {0.05, -0.03, 0.05295, 0.05, -0.23, 0.05295, 0.05, 0.17, 0.05295}},
      {14, {0.14446, 0.03719, 0.10962, 0.05, -0.23, 0.10962, -0.04446, 0.10281, 0.10962}},
      {18, {0.05, 0.17, 0.05295, 0.05, -0.23, 0.05295, 0.05, -0.03, 0.05295}},
      {21, {-0.13893, 0.03562, 0.10962, 0.23893, -0.09562, 0.10962, 0.05, -0.03, 0.10962}},
      {24, {0.01537, -0.22698, 0.063335, 0.08463, 0.16698, 0.063335, 0.05, -0.03, 0.063335}},
      {25, {0.05, -0.23, 0.05295, 0.05, 0.17, 0.05295, 0.05, -0.03, 0.05295}},
      {26, {0.05, -0.23, 0.05295, 0.05, 0.17, 0.05295, 0.05, -0.03, 0.05295}},
  };
  const Eigen::Vector3d center(0.05, -0.03, 0.0529462);
  for (const auto& [elapsed, expected] : table) {
    INFO("elapsed " << elapsed);
    CHECK(shuffle.is_running(0, elapsed));
    for (int mug = 0; mug < 3; ++mug) {
      const Eigen::Vector3d pos = center + shuffle.offset(0, mug, elapsed);
      for (int i = 0; i < 3; ++i) {
        CHECK(pos[i] == Approx(expected[static_cast<std::size_t>(3 * mug + i)]).margin(6e-6));
      }
    }
  }
  CHECK_FALSE(shuffle.is_running(0, 3));
  CHECK_FALSE(shuffle.is_running(0, 27));
}

TEST_CASE("Mugs keep their distance and every swap completes", "[shell]") {
  Bench bench(15);
  RandomStream random(7, 0, 0);
  for (int round = 0; round < 60; ++round) {
    const int steps = random.integer(20, 400);
    const int swaps = random.integer(2, 15);
    std::vector<int> pairs(15);
    for (int& pair : pairs) pair = random.integer(0, 2);
    bench.swaps.reset(0, 3, steps, swaps, pairs);
    const int per_swap = steps / swaps;
    for (int elapsed = 3; elapsed < bench.swaps.end(0); ++elapsed) {
      std::vector<Eigen::Vector3d> at(3);
      for (int mug = 0; mug < 3; ++mug) {
        at[static_cast<std::size_t>(mug)] = bench.swaps.offset(0, mug, elapsed);
      }
      for (int mug = 0; mug < 3; ++mug) {
        const double gap =
            (at[static_cast<std::size_t>(mug)] - at[static_cast<std::size_t>((mug + 1) % 3)])
                .norm();
        REQUIRE(gap >= MIN_DIST - 1e-12);
        REQUIRE(at[static_cast<std::size_t>(mug)].z() >= 0);
        REQUIRE(at[static_cast<std::size_t>(mug)].z() <= SWAP_ARC_HEIGHT);
      }
      if ((elapsed - 3) % per_swap != 0) continue;  // else: between two swaps, or left over
      for (int mug = 0; mug < 3; ++mug) {
        const int slot = bench.swaps.slot_of(0, (elapsed - 3) / per_swap, mug);
        const Eigen::Vector3d expected(0, (slot - 1) * MIN_DIST, 0);
        REQUIRE((at[static_cast<std::size_t>(mug)] - expected).norm() < 1e-12);
      }
    }
    bool used[3] = {};
    for (int mug = 0; mug < 3; ++mug) used[bench.swaps.final_slot(0, mug)] = true;
    CHECK((used[0] && used[1] && used[2]));
  }
}

}  // namespace
}  // namespace engram::tasks
