// Batteries that stand, lie and stay in place; the hole of the socket.
#include "mjcf/battery.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <vector>

#include "tests/core/sim/physics_fixture.h"

namespace engram {
namespace {

using test::Placement, test::Rig;

const Eigen::Quaterniond kUpright(mjcf::kBatteryQuat[0], mjcf::kBatteryQuat[1],
                                  mjcf::kBatteryQuat[2], mjcf::kBatteryQuat[3]);
const Eigen::Quaterniond kTurn(mjcf::kQuarterTurn[0], mjcf::kQuarterTurn[1], mjcf::kQuarterTurn[2],
                               mjcf::kQuarterTurn[3]);
const Eigen::Vector3d kSocket(0.15, 0.0, 0.015);
constexpr double kInSocket = 0.0405;  // m

double tilt(const Rig& rig, int prop) {
  const double* q = rig.state().prop_quat_of(0, prop);
  const Eigen::Vector3d axis =
      Eigen::Quaterniond(q[0], q[1], q[2], q[3]) * Eigen::Vector3d(1, 0, 0);
  return std::acos(std::min(1.0, std::abs(axis.z())));
}

BatchOptions with_sleep(bool sleep) {
  BatchOptions options{.sleep = sleep};
  return options;
}

// Two batteries and a socket.
Rig make_rig(const std::vector<Placement>& batteries, bool sleep) {
  std::vector<mjcf::Prop> props = {mjcf::battery("battery_0"), mjcf::battery("battery_1"),
                                   mjcf::battery_socket("socket")};
  return {std::move(props),
          {batteries[0], batteries[1], {kSocket, PropStatus::kAsleep, kTurn}},
          with_sleep(sleep)};
}

TEST_CASE("A battery weighs what its cylinder does", "[battery]") {
  const mjcf::Prop prop = mjcf::battery("battery");
  CHECK(prop.mass == Approx(0.018850).epsilon(1e-4));
  CHECK(prop.inertia[0] == Approx(0.5 * prop.mass * 1e-4));
  CHECK(prop.inertia[1] == Approx(prop.mass * (3e-4 + 36e-4) / 12));
  CHECK(prop.inertia[1] == prop.inertia[2]);
}

TEST_CASE("The socket's hole is as published", "[battery]") {
  const mjcf::SocketShape shape;
  CHECK(shape.hole_half_width() == Approx(0.0184));
  CHECK(shape.floor_height() == Approx(0.0105));
  const mjcf::Prop socket = mjcf::battery_socket("socket", shape);
  std::vector<std::array<double, 6>> boxes;
  for (const mjcf::Geom& part : socket.geoms) {
    if (!part.collides) continue;
    boxes.push_back(
        {part.size[0], part.size[1], part.size[2], part.pos[0], part.pos[1], part.pos[2]});
  }
  const std::vector<std::array<double, 6>> expected = {{0.048, 0.040, 0.00525, 0, 0, -0.00975},
                                                       {0.0148, 0.040, 0.015, 0.0332, 0, 0},
                                                       {0.0148, 0.040, 0.015, -0.0332, 0, 0},
                                                       {0.0184, 0.0108, 0.015, 0, 0.0292, 0},
                                                       {0.0184, 0.0108, 0.015, 0, -0.0292, 0}};
  REQUIRE(boxes.size() == expected.size());
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    for (std::size_t k = 0; k < 6; ++k) CHECK(boxes[i][k] == Approx(expected[i][k]).margin(1e-12));
  }
}

TEST_CASE("Batteries on the table and in the socket stand still for thousands of steps",
          "[battery]") {
  const bool sleep = GENERATE(true, false);
  const Eigen::Vector3d on_table(-0.05, 0.0, 0.030);
  const Eigen::Vector3d in_socket(kSocket.x(), kSocket.y(), kInSocket);
  Rig rig = make_rig(
      {{on_table, PropStatus::kAwake, kUpright}, {in_socket, PropStatus::kAwake, kUpright}}, sleep);
  rig.rest(2000);
  INFO("sleep " << sleep);
  CHECK((rig.pos(0) - on_table).norm() < 1e-3);
  CHECK((rig.pos(1) - in_socket).norm() < 1e-3);
  CHECK(tilt(rig, 0) < 0.005);
  CHECK(tilt(rig, 1) < 0.005);
  CHECK((rig.status(0) == PropStatus::kAsleep) == sleep);
  CHECK((rig.status(1) == PropStatus::kAsleep) == sleep);
}

TEST_CASE("A battery let go askew in the hole rights itself", "[battery]") {
  const Eigen::Quaterniond askew(
      Eigen::AngleAxisd(5 * std::numbers::pi / 180, Eigen::Vector3d::UnitY()));
  Rig rig =
      make_rig({{{kSocket.x(), kSocket.y() + 0.003, 0.046}, PropStatus::kAwake, askew * kUpright},
                {{-0.05, 0, 0.03}, PropStatus::kAsleep, kUpright}},
               GENERATE(true, false));
  rig.rest(60);
  CHECK(tilt(rig, 0) < 0.01);
  CHECK(rig.pos(0).z() == Approx(kInSocket).margin(5e-4));
}

TEST_CASE("A battery that lies does not roll for ever", "[battery]") {
  const Eigen::Quaterniond lying(Eigen::AngleAxisd(0.2, Eigen::Vector3d::UnitX()));
  Rig rig = make_rig({{{-0.05, 0, 0.0105}, PropStatus::kAwake, lying},
                      {{0.05, 0.2, 0.03}, PropStatus::kAsleep, kUpright}},
                     true);
  rig.rest(60);
  CHECK(rig.status(0) == PropStatus::kAsleep);
  CHECK(rig.pos(0).z() == Approx(0.0095).margin(6e-4));
}

TEST_CASE("A battery that moves leaves its neighbour in the tray asleep", "[battery][sleep]") {
  Rig rig = make_rig({{{-0.05, 0, 0.05}, PropStatus::kAwake, kUpright},
                      {{0.0, 0, 0.03}, PropStatus::kAsleep, kUpright}},
                     true);
  rig.rest(5);
  CHECK(rig.status(1) == PropStatus::kAsleep);
  rig.rest(60);
  CHECK(rig.pos(0).z() == Approx(0.03).margin(5e-4));
  CHECK(rig.pos(1) == Eigen::Vector3d(0, 0, 0.03));
}

TEST_CASE("A battery stands on another", "[battery]") {
  Rig rig = make_rig({{{-0.05, 0, 0.03}, PropStatus::kAwake, kUpright},
                      {{-0.05, 0, 0.0901}, PropStatus::kAwake, kUpright}},
                     true);
  for (int step = 0; step < 100; ++step) {
    rig.rest(1);
    REQUIRE(rig.pos(1).z() == Approx(0.09).margin(5e-4));
  }
}

TEST_CASE("What stands on a battery falls when it is taken away", "[battery][sleep]") {
  Rig rig = make_rig({{{-0.05, 0, 0.03}, PropStatus::kAsleep, kUpright},
                      {{-0.05, 0, 0.0901}, PropStatus::kAsleep, kUpright}},
                     true);
  rig.rest(40);
  REQUIRE(rig.status(1) == PropStatus::kAsleep);
  // The lower one is pushed aside by the closed gripper.
  rig.move({-0.15, 0, 0.1}, 25, -0.6);
  rig.move({-0.15, 0, 0.02}, 25, -0.6, 0.4F);
  rig.move({-0.0, 0, 0.02}, 40, -0.6, 0.3F);
  rig.move({-0.1, 0.3, 0.3}, 40, -0.6);
  CHECK(rig.pos(1).z() < 0.07);
}

}  // namespace
}  // namespace engram
