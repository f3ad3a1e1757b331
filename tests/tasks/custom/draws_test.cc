#include "tasks/custom/draws.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <set>

#include "core/base/error.h"

namespace engram::tasks {
namespace {

using Kind = CustomDraw::Kind;

// Draws of a number of environments.
struct Drawn {
  explicit Drawn(std::vector<CustomDraw> list, int count = 200)
      : memory(count), pin_memory(count), draws(std::move(list)) {
    // As in a batch: the engine's variable comes first.
    std::vector<RandomVariable> variables = {
        {.name = kRobotNoiseVariable, .low = -1, .high = 1, .unit = "", .description = ""}};
    for (const RandomVariable& own : draws.variables()) variables.push_back(own);
    pins = PinTable(pin_memory, variables);
    draws.bind(memory);
  }
  void sample() {
    for (int env = 0; env < memory.num_envs(); ++env) {
      draws.sample(Episode(pins, env, static_cast<std::uint64_t>(env), 0));
    }
  }
  template <class T>
  const T* row(const char* name, int env) const {
    return reinterpret_cast<const T*>(memory.find(draw_column(name)).row(env));
  }

  ColumnStore memory;
  ColumnStore pin_memory;
  PinTable pins;
  CustomDraws draws;
};

TEST_CASE("Numbers are drawn from their range, all of it", "[own_tasks]") {
  Drawn drawn({{.name = "i", .kind = Kind::kInteger, .width = 2, .low = -1, .high = 3},
               {.name = "r", .kind = Kind::kReal, .low = 0.5, .high = 0.75}});
  drawn.sample();
  std::set<int> seen;
  for (int env = 0; env < 200; ++env) {
    for (int k = 0; k < 2; ++k) seen.insert(drawn.row<std::int32_t>("i", env)[k]);
    const double real = *drawn.row<double>("r", env);
    CHECK((real >= 0.5 && real < 0.75));
  }
  CHECK(seen == std::set<int>{-1, 0, 1, 2, 3});
}

TEST_CASE("Orders and choices have different numbers", "[own_tasks]") {
  Drawn drawn({{.name = "order", .kind = Kind::kOrder, .width = 4, .high = 3},
               {.name = "choice", .kind = Kind::kChoice, .width = 2, .high = 5}});
  drawn.sample();
  std::set<std::vector<int>> orders;
  for (int env = 0; env < 200; ++env) {
    const auto* order = drawn.row<std::int32_t>("order", env);
    CHECK(std::set<int>(order, order + 4) == std::set<int>{0, 1, 2, 3});
    orders.emplace(order, order + 4);
    const auto* choice = drawn.row<std::int32_t>("choice", env);
    CHECK((choice[0] != choice[1] && std::max(choice[0], choice[1]) <= 5));
  }
  CHECK(orders.size() == 24);
}

TEST_CASE("Places are apart and within their area", "[own_tasks]") {
  CustomDraw places{.name = "places", .kind = Kind::kPlaces, .width = 10};
  places.area_low = {-0.2, -0.3};
  places.area_high = {0.1, 0.3};
  places.low = -0.3;
  places.high = 0.3;
  places.min_distance = 0.1;
  Drawn drawn({places});
  drawn.sample();
  for (int env = 0; env < 200; ++env) {
    const double* at = drawn.row<double>("places", env);
    for (int i = 0; i < 5; ++i) {
      CHECK((at[2 * i] >= -0.2 && at[2 * i] <= 0.1 && std::abs(at[2 * i + 1]) <= 0.3));
      for (int k = 0; k < i; ++k) {
        CHECK(std::hypot(at[2 * i] - at[2 * k], at[2 * i + 1] - at[2 * k + 1]) >= 0.1);
      }
    }
  }
  places.min_distance = 0.5;
  CHECK_THROWS_WITH(CustomDraws({places}),
                    "draw 'places': 5 places 0.5 m apart do not fit into their area");
}

TEST_CASE("Draws can be pinned, and ranges narrowed", "[own_tasks]") {
  Drawn drawn({{.name = "steps", .kind = Kind::kInteger, .low = 1, .high = 9, .constant = "STEPS"},
               {.name = "order", .kind = Kind::kOrder, .width = 3, .high = 2}},
              2);
  const std::vector<Pin> pins = {{"order", {2, 0, 1}}};
  drawn.pins.check(pins);
  drawn.pins.set(0, pins);
  const ConstantTable narrow = {{"STEPS", ConstantList{Constant(4), Constant(4)}}};
  drawn.pins.narrow(1, drawn.pins.narrowed_ranges(narrow));
  drawn.sample();
  const auto* order = drawn.row<std::int32_t>("order", 0);
  CHECK(std::vector<int>(order, order + 3) == std::vector<int>{2, 0, 1});
  CHECK(*drawn.row<std::int32_t>("steps", 1) == 4);
  CHECK_THROWS_AS(drawn.pins.check({{"order", {2, 2, 1}}}), Error);
}

}  // namespace
}  // namespace engram::tasks
