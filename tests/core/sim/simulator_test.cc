#include "core/sim/simulator.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <limits>
#include <memory>
#include <vector>

#include "core/base/error.h"
#include "core/robot/lane_block.h"
#include "tests/core/sim/columns_fixture.h"

namespace engram {
namespace {

using test::mixed_model, test::MixedColumns;

constexpr int kEnvs = 21;

DriveTarget hold() {
  DriveTarget drive;
  std::copy(test::kStartPose.begin(), test::kStartPose.end(), drive.qpos.begin());
  return drive;
}

std::vector<std::byte> bytes_of(const MixedColumns& columns, int env) {
  std::vector<std::byte> bytes(columns.store.row_bytes());
  columns.store.save_row(env, bytes);
  return bytes;
}

// Environments that differ in where the cube falls, in what the drives follow, and in when and what
// the cube touches.
struct Environments {
  explicit Environments(const SimulatorOptions& options)
      : simulator(mixed_model(), options, 1, kEnvs) {
    for (int env = 0; env < kEnvs; ++env) {
      const int kind = env % 5;
      const double height = 0.03 + 0.02 * kind;
      columns.place(env, test::kCube0, {0.02 * kind, 0.4, height}, PropStatus::kAwake);
      if (env % 3 == 1) {
        columns.place(env, test::kCube1, {0.02 * kind, 0.41, height + 0.041}, PropStatus::kAwake);
      }
      drives[static_cast<std::size_t>(env)] = hold();
      drives[static_cast<std::size_t>(env)].qpos[1] += 0.05 * kind;
    }
  }
  // Returns which environments were good.
  std::array<bool, kEnvs> step() {
    std::array<bool, kEnvs> good{};
    simulator.step(columns.state, 0, 0, drives, good.data(), nullptr);
    return good;
  }

  MixedColumns columns{kEnvs};
  std::array<DriveTarget, kEnvs> drives;
  Simulator simulator;
};

TEST_CASE("Environments side by side move as each would alone, to the bit", "[simulator]") {
  const bool sleep = GENERATE(true, false);
  Environments alone({5, sleep, 1});
  CHECK(alone.simulator.lanes() == 1);
  Environments together({5, sleep, 0});
  for (int step = 0; step < 20; ++step) {
    alone.step();
    together.step();
    for (int env = 0; env < kEnvs; ++env) {
      REQUIRE(bytes_of(alone.columns, env) == bytes_of(together.columns, env));
    }
  }
  CHECK(alone.columns.state.prop_pos_of(0, test::kCube0)[2] == Approx(0.02).margin(1e-3));
}

TEST_CASE("A diverged environment stays as it was, and the others go on", "[simulator]") {
  Environments batch({});
  Environments undisturbed({});
  constexpr int kBad = 2;
  batch.columns.state.qvel.row(kBad)[3] = std::numeric_limits<double>::quiet_NaN();
  const std::vector<std::byte> before = bytes_of(batch.columns, kBad);
  const std::array<bool, kEnvs> good = batch.step();
  undisturbed.step();
  for (int env = 0; env < kEnvs; ++env) {
    CHECK(good[static_cast<std::size_t>(env)] == (env != kBad));
    if (env != kBad) CHECK(bytes_of(batch.columns, env) == bytes_of(undisturbed.columns, env));
  }
  CHECK(bytes_of(batch.columns, kBad) == before);
}

TEST_CASE("Physics that diverges during the step is not stored", "[simulator]") {
  MixedColumns columns;
  Simulator simulator(mixed_model(), {}, 1, 1);
  columns.state.prop_qvel_of(0, test::kCube0)[0] = 9e9;  // plausible still, but not for long
  const std::vector<std::byte> before = bytes_of(columns, 0);
  bool good = true;
  for (int step = 0; step < 100 && good; ++step) good = simulator.step(columns.state, 0, 0, hold());
  CHECK_FALSE(good);
  // The simulator goes on with a good state.
  MixedColumns other;
  CHECK(simulator.step(other.state, 0, 0, hold()));
}

TEST_CASE("Without substeps nothing changes", "[simulator]") {
  MixedColumns columns;
  Simulator simulator(mixed_model(), {0, true, 0}, 1, 1);
  const std::vector<std::byte> before = bytes_of(columns, 0);
  CHECK(simulator.step(columns.state, 0, 0, hold()));
  CHECK(bytes_of(columns, 0) == before);
}

TEST_CASE("A clock counts poses and the search for contacts as dynamics", "[simulator]") {
  MixedColumns columns;  // with cubes that are awake
  columns.place(0, test::kCube0, {0, 0.4, 0.03}, PropStatus::kAwake);
  const SimulatorOptions options;
  Simulator simulator(mixed_model(), options, 1, 1);
  StepClock clock(1);
  clock.worker(0).start();
  CHECK(simulator.step(columns.state, 0, 0, hold(), &clock.worker(0)));
  const auto substeps = static_cast<std::uint64_t>(options.substeps);
  const StepClock::Ticks marks = clock.marks();
  CHECK(marks[static_cast<std::size_t>(StepPart::kDynamics)] == 4 * substeps);
  CHECK(marks[static_cast<std::size_t>(StepPart::kWake)] == substeps + 1);
}

TEST_CASE("Unknown numbers of lanes are refused with those that are allowed", "[simulator]") {
  CHECK_THROWS_WITH(Simulator(mixed_model(), {5, true, 3}, 1, 1),
                    Catch::StartsWith("lanes: 3 given; this processor allows: 0, 1"));
}

TEST_CASE("TCP poses are those of the arm's forward kinematics", "[simulator]") {
  MixedColumns columns(kEnvs);
  for (int env = 0; env < kEnvs; ++env) columns.state.qpos.row(env)[0] = 0.04 * env;
  Simulator simulator(mixed_model(), {}, 1, kEnvs);
  simulator.update_tcp(columns.state, 0, kEnvs, 0);
  for (int env = 0; env < kEnvs; ++env) {
    const Pose pose = mixed_model().arm().forward(columns.state.qpos.row(env));
    for (int i = 0; i < 3; ++i) {
      CHECK(columns.state.tcp_pos.row(env)[i] == Approx(pose.pos[i]).margin(1e-6));
    }
    CHECK(std::abs(columns.state.tcp_quat.row(env)[0]) ==
          Approx(std::abs(pose.quat.w())).margin(1e-6));
  }
}

}  // namespace
}  // namespace engram
