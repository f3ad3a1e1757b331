// Balls that nobody touches, against launches measured in the original benchmark.
#include <catch2/catch.hpp>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "tests/build_paths.h"
#include "tests/env_helpers.h"

namespace engram {
namespace {

using Vector = Eigen::Vector3d;

struct Moment {
  int step = 0;
  Vector pos;       // m
  Vector velocity;  // m/s
};

// Moments of each task and episode, in order, the first of them the launch.
using Launches = std::map<std::pair<std::string, int>, std::vector<Moment>>;

const Launches& measured() {
  static const Launches launches = [] {
    std::ifstream file(std::string(test::kData) + "/free_balls.csv");
    std::string line;
    std::getline(file, line);  // names
    Launches read;
    while (std::getline(file, line)) {
      std::istringstream fields(line);
      std::vector<std::string> row;
      for (std::string field; std::getline(fields, field, ',');) row.push_back(field);
      REQUIRE(row.size() == 9);
      const auto number = [&](std::size_t i) { return std::stod(row[i]); };
      read[{row[0], std::stoi(row[1])}].push_back({std::stoi(row[2]),
                                                   {number(3), number(4), number(5)},
                                                   {number(6), number(7), number(8)}});
    }
    return read;
  }();
  return launches;
}

std::unique_ptr<Batch> launch(const std::string& id, const Moment& start, bool sleep) {
  const BatchOptions options{.auto_reset = AutoReset::kOff,
                             .sleep = sleep,
                             .pins = {{"ball_x", {start.pos.x()}},
                                      {"ball_y", {start.pos.y()}},
                                      {"velocity_x", {start.velocity.x()}},
                                      {"velocity_y", {start.velocity.y()}}}};
  return test::make_running(id, options);
}

TEST_CASE("Balls that nobody touches go the way of the original's", "[intercept][rolling]") {
  REQUIRE(measured().size() == 18);
  const bool sleep = GENERATE(true, false);
  for (const auto& [launched, moments] : measured()) {
    const auto batch = launch(launched.first, moments.front(), sleep);
    const Eigen::Map<const Vector> pos(batch->state().prop_pos_of(0, 0));
    const Eigen::Map<const Vector> velocity(batch->state().prop_qvel_of(0, 0));
    int step = 0;
    for (const Moment& moment : moments) {
      for (; step < moment.step; ++step) test::step(*batch, Policy::kZero);
      INFO(launched.first << ", episode " << launched.second << ", step " << step);
      CHECK(1000 * (pos - moment.pos).norm() < 3.0);
      CHECK((velocity - moment.velocity).norm() < 0.02);
    }
    CHECK(step == 60);
  }
}

}  // namespace
}  // namespace engram
