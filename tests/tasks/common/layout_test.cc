#include "tasks/common/layout.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <vector>

#include "tasks/common/overlap_guard.h"

namespace engram::tasks {
namespace {

Layout layout_of(const std::vector<Vec2>& points) {
  Layout layout;
  for (const Vec2& point : points) layout.push_back(point);
  return layout;
}

double nearest_pair(const Layout& layout) {
  double least = 1e9;
  for (std::size_t i = 0; i < layout.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) least = std::min(least, (layout[i] - layout[j]).norm());
  }
  return least;
}

constexpr double kSize = 0.02;  // m: half the side of a cube as large as the objects

TEST_CASE("Nominal slots have the published coordinates", "[layout]") {
  constexpr ArcParams kRound{.radius = 0.3, .compression = 0};
  constexpr ArcParams kWide{.radius = 0.45, .compression = 0.025};
  struct Row {
    int count;
    ArcParams arc;
    double spacing;  // of the nearest neighbours
    std::vector<Vec2> slots;
  };
  const Row table[] = {
      {3, {}, 0.1, {{0, 0.1}, {0, 0}, {0, -0.1}}},
      {5, {}, 0.1618, {{-0.15729, -0.23532}, {-0.00729, -0.15134}, {0.05, 0}}},
      {6, kRound, 0.1553, {{-0.17235, -0.28978}, {-0.03787, -0.21213}, {0.03978, -0.07765}}},
      {9,
       {},
       0.0797,
       {{-0.19791, -0.19544},
        {-0.10000, -0.18481},
        {-0.02019, -0.14284},
        {0.03191, -0.07761},
        {0.05, 0}}},
      {15,
       kRound,
       0.0627,
       {{-0.21864, -0.29836},
        {-0.15729, -0.28532},
        {-0.10000, -0.25981},
        {-0.04926, -0.22294},
        {-0.00729, -0.17634},
        {0.02406, -0.12202},
        {0.04344, -0.06237},
        {0.05, 0}}},
      {15,
       kWide,
       0.0693,
       {{-0.20296, -0.27253},
        {-0.11094, -0.27798},
        {-0.02500, -0.26471},
        {0.05111, -0.23442},
        {0.11406, -0.18950},
        {0.16110, -0.13303},
        {0.19017, -0.06856},
        {0.20000, 0}}},
  };
  for (const auto& [count, arc, spacing, slots] : table) {
    const Layout nominal = nominal_slots(count, arc);
    REQUIRE(nominal.size() == static_cast<std::size_t>(count));
    CHECK(nearest_pair(nominal) == Approx(spacing).margin(1e-4));
    for (std::size_t i = 0; i < slots.size(); ++i) {
      CHECK((nominal[i] - slots[i]).norm() < 1e-5);
      const Vec2& mirrored = nominal[nominal.size() - 1 - i];
      CHECK((mirrored - Vec2(slots[i].x(), -slots[i].y())).norm() < 1e-5);
    }
  }
}

TEST_CASE("Jitter is normal with 10 mm and keeps slots 60 mm apart", "[layout]") {
  for (const int count : {3, 5, 9}) {
    const Layout nominal = nominal_slots(count);
    double squares = 0;
    Vec2 sum = Vec2::Zero();
    constexpr int kRounds = 2000;
    for (int seed = 0; seed < kRounds; ++seed) {
      RandomStream random(static_cast<std::uint64_t>(seed), 0, 0);
      const Layout jittered = jitter_slots(nominal, kSize, random);
      REQUIRE(jittered.size() == nominal.size());
      REQUIRE(nearest_pair(jittered) >= 0.06);
      for (std::size_t i = 0; i < jittered.size(); ++i) {
        squares += (jittered[i] - nominal[i]).squaredNorm();
        sum += jittered[i] - nominal[i];
      }
    }
    const double points = kRounds * count;
    CHECK(std::sqrt(squares / (2 * points)) == Approx(0.01).epsilon(0.03));
    CHECK((sum / points).norm() < 0.001);
  }
}

TEST_CASE("A crowded slot stays where it is nominally", "[layout]") {
  RandomStream random(1, 0, 0);
  const Layout crowded = layout_of({{0, 0}, {0, 0}});
  const Layout jittered = jitter_slots(crowded, kSize, random);
  // 60 mm are six deviations: no attempt succeeds.
  CHECK(jittered[1] == Vec2(0, 0));
  CHECK(jittered[0] != Vec2(0, 0));
}

TEST_CASE("Whole layouts are drawn until all pairs keep 60 mm", "[layout]") {
  struct Row {
    int count;
    ArcParams arc;
    double accepted;  // share of the layouts
  };
  const Row table[] = {
      {6, {.radius = 0.3, .compression = 0}, 1},
      {9, {}, 1},
      {15, {.radius = 0.45, .compression = 0.025}, 0.95},
      {15, {.radius = 0.3, .compression = 0}, 0},
  };
  for (const auto& [count, arc, accepted] : table) {
    const Layout nominal = nominal_slots(count, arc);
    std::vector<double> distances;
    int good = 0;
    constexpr int kRounds = 1000;
    for (std::uint64_t seed = 0; seed < kRounds; ++seed) {
      RandomStream random(seed, 0, 0);
      distances.push_back(nearest_pair(jitter_layout(nominal, kSize, random)));
      good += distances.back() >= 0.06 ? 1 : 0;
    }
    INFO(count << " slots");
    CHECK(static_cast<double>(good) / kRounds == Approx(accepted).margin(0.02));
    if (accepted > 0) continue;
    // The most spacious of 20 attempts.
    std::sort(distances.begin(), distances.end());
    CHECK(distances[kRounds / 2] == Approx(0.0515).margin(0.001));
    CHECK(distances[kRounds / 100] == Approx(0.046).margin(0.001));
  }
}

TEST_CASE("Every permutation of slots is equally likely", "[layout]") {
  const Layout slots = layout_of({{0, 0}, {1, 0}, {2, 0}});
  std::map<std::array<int, 3>, int> counts;
  for (std::uint64_t seed = 0; seed < 6000; ++seed) {
    RandomStream random(seed, 0, 0);
    const Layout keys = assign_slots(slots, random);
    ++counts[{static_cast<int>(keys[0].x()), static_cast<int>(keys[1].x()),
              static_cast<int>(keys[2].x())}];
  }
  CHECK(counts.size() == 6);
  for (const auto& [order, count] : counts) CHECK(std::abs(count - 1000) < 150);
}

TEST_CASE("Spread and stretch turn the test vector into the published layout", "[layout]") {
  Layout layout = layout_of({{0.011, -0.096}, {0.006, 0.108}, {-0.004, 0.009}});
  RandomStream random(1, 0, 0);
  spread_and_stretch(layout, {}, kSize, random);
  CHECK((layout[0] - Vec2(0.011, -0.199)).norm() < 1e-12);
  CHECK((layout[1] - Vec2(0.006, 0.209)).norm() < 1e-12);
  CHECK((layout[2] - Vec2(-0.004, 0.011)).norm() < 1e-12);
}

TEST_CASE("Keys that are too close are pushed apart before the stretch", "[layout]") {
  int moved = 0;
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    Layout layout = layout_of({{0, 0.1}, {0, 0.05}, {0, -0.1}});
    RandomStream random(seed, 0, 0);
    spread_and_stretch(layout, {}, kSize, random);
    CHECK(layout[0].x() == 0);  // the first one stays
    moved += layout[1].x() != 0 ? 1 : 0;
    Layout before = layout;
    for (Vec2& point : before) point.y() /= 2;
    if (nearest_pair(before) >= 0.09) continue;
    CHECK(layout[1].x() != 0);  // only after 80 attempts
  }
  CHECK(moved == 200);
}

TEST_CASE("Stretched rows have the published spread and are clamped", "[layout]") {
  std::vector<double> x;
  std::vector<double> y;
  int spread = 0;
  constexpr int kRounds = 4000;
  for (std::uint64_t seed = 0; seed < kRounds; ++seed) {
    RandomStream random(seed, 0, 0);
    Layout layout = assign_slots(jitter_slots(nominal_slots(3), kSize, random), random);
    spread += nearest_pair(layout) < 0.09 ? 1 : 0;
    spread_and_stretch(layout, {}, kSize, random);
    for (const Vec2& point : layout) {
      x.push_back(point.x());
      y.push_back(point.y());
      REQUIRE(std::abs(point.y()) <= 0.5);
    }
  }
  std::sort(x.begin(), x.end());
  std::sort(y.begin(), y.end());
  const auto at = [](const std::vector<double>& sorted, double fraction) {
    return sorted[static_cast<std::size_t>(fraction * static_cast<double>(sorted.size()))];
  };
  CHECK(at(y, 0.005) == Approx(-0.243).margin(0.012));
  CHECK(at(y, 0.995) == Approx(0.243).margin(0.012));
  CHECK(at(x, 0.995) == Approx(0.085).margin(0.02));
  CHECK(at(x, 0.005) == Approx(-0.085).margin(0.02));
  CHECK(static_cast<double>(spread) / kRounds == Approx(0.43).margin(0.04));

  Layout wide = layout_of({{0, 0.7}, {0, 0}, {0, -0.7}});
  RandomStream random(1, 0, 0);
  spread_and_stretch(wide, {}, kSize, random);
  CHECK(wide[0].y() == 0.5);
  CHECK(wide[2].y() == -0.5);
}

double cube_clearance(std::size_t, std::size_t, const Vec2& offset) {
  return square_clearance(0.02, offset);
}

TEST_CASE("Clearance of squares is the gap between them or minus their overlap", "[layout]") {
  CHECK(square_clearance(0.02, {0.05, 0}) == Approx(0.01));
  CHECK(square_clearance(0.02, {-0.05, 0.03}) == Approx(0.01));
  CHECK(square_clearance(0.02, {0.043, -0.044}) == Approx(0.005));
  CHECK(square_clearance(0.02, {0.03, 0}) == Approx(-0.01));
  CHECK(square_clearance(0.02, {0.03, 0.035}) == Approx(-0.005));
  CHECK(square_clearance(0.02, {0, 0}) == Approx(-0.04));
  CHECK(square_clearance(0.02, {0.04, 0.01}) == Approx(0).margin(1e-12));
}

TEST_CASE("Separation removes overlaps and moves nothing else", "[layout]") {
  const std::vector<std::vector<Vec2>> crafted = {
      {{0, 0}, {0.03, 0}},
      {{0, 0}, {0, 0}},  // coincident: apart along x
      {{0, 0}, {0.03, 0.035}, {0.06, 0}},
      {{0, 0}, {0.039, 0}, {0.078, 0}, {0.117, 0}},
      {{0, 0}, {0.01, 0.01}, {-0.01, 0.01}, {0.01, -0.01}, {-0.01, -0.01}},
  };
  for (const std::vector<Vec2>& points : crafted) {
    Layout layout = layout_of(points);
    CHECK_FALSE(is_clear(layout, cube_clearance));
    separate(layout, cube_clearance);
    CHECK(is_clear(layout, cube_clearance));
    Vec2 drift = Vec2::Zero();
    for (std::size_t i = 0; i < points.size(); ++i) drift += layout[i] - points[i];
    CHECK(drift.norm() < 1e-12);  // both halves of every move
  }
  Layout pair = layout_of({{0, 0}, {0, 0}});
  separate(pair, cube_clearance);
  CHECK(pair[0].y() == 0);
  CHECK(pair[1].x() - pair[0].x() > 0.041);
  Layout clear = layout_of({{0, 0}, {0.0411, 0}});
  separate(clear, cube_clearance);
  CHECK(clear[1] == Vec2(0.0411, 0));
}

TEST_CASE("A clear layout is drawn at most 50 times and then separated", "[layout]") {
  int draws = 0;
  const auto hopeless = [&] {
    ++draws;
    return layout_of({{0, 0}, {0.02, 0}});
  };
  const Layout separated = draw_clear_layout(hopeless, cube_clearance);
  CHECK(draws == 50);
  CHECK(is_clear(separated, cube_clearance));
  draws = 0;
  const auto third = [&] { return layout_of({{0, 0}, {++draws < 3 ? 0.02 : 0.1, 0}}); };
  CHECK(draw_clear_layout(third, cube_clearance)[1].x() == 0.1);
  CHECK(draws == 3);
}

}  // namespace
}  // namespace engram::tasks
